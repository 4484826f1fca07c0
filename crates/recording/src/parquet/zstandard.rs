//! Pages that Zstandard has compressed, as pyarrow and Polars write them on demand.
//!
//! The library would decompress them by C code, which no release is linked with. It is told that
//! they are plain, and hands them on as they are.

use std::fs::File;
use std::io::Read as _;
use std::sync::Arc;

use bytes::Bytes;
use parquet::basic::{Compression, CompressionCodec};
use parquet::column::page::{Page, PageMetadata, PageReader};
use parquet::column::reader::{ColumnReader, get_column_reader};
use parquet::errors::ParquetError;
use parquet::file::metadata::ColumnChunkMetaData;
use parquet::file::serialized_reader::SerializedPageReader;

/// A page that grows beyond this is damaged, B.
const MOST_BYTES: u64 = 1 << 30;

/// The reader of a column that Zstandard has compressed; `None` for any other.
pub(super) fn column_reader(
    file: &Arc<File>,
    column: &ColumnChunkMetaData,
    rows: usize,
) -> Result<Option<ColumnReader>, ParquetError> {
    if !matches!(column.compression(), Compression::ZSTD(_)) {
        return Ok(None);
    }
    let plain = column.clone().into_builder().set_compression_codec(CompressionCodec::UNCOMPRESSED).build()?;
    let pages = ZstandardPages(SerializedPageReader::new(Arc::clone(file), &plain, rows, None)?);
    Ok(Some(get_column_reader(column.column_descr_ptr(), Box::new(pages))))
}

struct ZstandardPages(SerializedPageReader<File>);

impl Iterator for ZstandardPages {
    type Item = Result<Page, ParquetError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.get_next_page().transpose()
    }
}

impl PageReader for ZstandardPages {
    fn get_next_page(&mut self) -> Result<Option<Page>, ParquetError> {
        let Some(mut page) = self.0.get_next_page()? else { return Ok(None) };
        match &mut page {
            // Levels stand before the values, and are never compressed.
            Page::DataPageV2 { buf, def_levels_byte_len, rep_levels_byte_len, is_compressed, .. } => {
                if *is_compressed {
                    *buf = decompressed(buf, *def_levels_byte_len as usize + *rep_levels_byte_len as usize)?;
                }
            }
            Page::DataPage { buf, .. } | Page::DictionaryPage { buf, .. } => *buf = decompressed(buf, 0)?,
        }
        Ok(Some(page))
    }

    fn peek_next_page(&mut self) -> Result<Option<PageMetadata>, ParquetError> {
        self.0.peek_next_page()
    }

    fn skip_next_page(&mut self) -> Result<(), ParquetError> {
        self.0.skip_next_page()
    }
}

/// A page whose bytes from `from` on are compressed.
fn decompressed(page: &Bytes, from: usize) -> Result<Bytes, ParquetError> {
    let failed = |error: &dyn std::fmt::Display| ParquetError::General(format!("a page of Zstandard: {error}"));
    let (plain, packed) = page.split_at_checked(from).ok_or_else(|| failed(&"its levels are cut short"))?;
    let mut bytes = plain.to_vec();
    // A page without values has none to compress.
    if !packed.is_empty() {
        let frame = ruzstd::decoding::StreamingDecoder::new(packed).map_err(|error| failed(&error))?;
        frame.take(MOST_BYTES).read_to_end(&mut bytes).map_err(|error| failed(&error))?;
    }
    Ok(bytes.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use ruzstd::encoding::{CompressionLevel, compress_to_vec};

    #[test]
    fn levels_before_the_values_stay_as_they_are() {
        let packed = compress_to_vec(&b"twenty times the same, "[..], CompressionLevel::Fastest);
        let page = Bytes::from([b"levels".as_slice(), packed.as_slice()].concat());
        assert_eq!(decompressed(&page, 6).unwrap(), "levelstwenty times the same, ");
        assert_eq!(decompressed(&page.slice(..6), 6).unwrap(), "levels");
        assert!(decompressed(&page.slice(..5), 6).unwrap_err().to_string().contains("cut short"));
        assert!(decompressed(&page.slice(..page.len() - 3), 6).is_err());
    }
}
