//! A picture on paper and on disk: its width, its format, and the way from SVG to PDF
//! and PNG.
//!
//! PDF and PNG are made from the SVG with the embedded face, so that they are the same on every
//! machine. Text of a PDF stays text; a PNG has 300 dots an inch.

use std::path::Path;
use std::str::FromStr;
use std::sync::Arc;

use crate::engine::svg::MM;
use crate::engine::words::Weight;
use anyhow::{anyhow, bail, ensure};
use resvg::{tiny_skia, usvg};

/// Points in an inch, and dots of a PNG.
const POINTS_PER_INCH: f32 = 72.0;
const DOTS_PER_INCH: f32 = 300.0;
/// Widths that a picture can have, mm.
const WIDTHS: std::ops::RangeInclusive<f64> = 60.0..=400.0;

/// Width of a picture on paper: 60 to 400 mm. A journal's double column of 180 mm is the default; a
/// single column has 88 mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PictureWidth(f64);

impl PictureWidth {
    /// A width in millimetres.
    ///
    /// # Errors
    /// If it is not within 60 to 400 mm.
    pub fn mm(width: f64) -> anyhow::Result<Self> {
        ensure!(WIDTHS.contains(&width), "a picture is 60 to 400 mm wide, not `{width}`");
        Ok(Self(width))
    }

    pub(crate) fn points(self) -> f64 {
        self.0 * MM
    }
}

impl Default for PictureWidth {
    fn default() -> Self {
        Self(180.0)
    }
}

/// Reads millimetres.
impl FromStr for PictureWidth {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> anyhow::Result<Self> {
        Self::mm(text.parse().map_err(|_| anyhow!("a picture is 60 to 400 mm wide, not `{text}`"))?)
    }
}

/// A format of picture files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PictureFormat {
    /// Scalable, for web pages and editors.
    Svg,
    /// Scalable, for papers.
    Pdf,
    /// Dots, 300 an inch.
    Png,
}

impl PictureFormat {
    /// By the extension of a file's name.
    ///
    /// # Errors
    /// If it is none of a picture.
    pub fn of(path: &Path) -> anyhow::Result<Self> {
        match path.extension().unwrap_or_default().to_ascii_lowercase().to_str() {
            Some("svg") => Ok(Self::Svg),
            Some("pdf") => Ok(Self::Pdf),
            Some("png") => Ok(Self::Png),
            _ => bail!("{}: a picture's name ends in .svg, .pdf or .png", path.display()),
        }
    }

    /// The content of a file of this format with the picture of an SVG.
    pub(crate) fn encode(self, svg: String) -> anyhow::Result<Vec<u8>> {
        let failed = |reason: &dyn std::fmt::Display| anyhow!("the picture cannot be converted: {reason}");
        if self == Self::Svg {
            return Ok(svg.into_bytes());
        }
        let mut options = usvg::Options { dpi: POINTS_PER_INCH, ..usvg::Options::default() };
        let fonts = Arc::make_mut(&mut options.fontdb);
        for weight in [Weight::Regular, Weight::Bold] {
            fonts.load_font_data(weight.font().to_vec());
        }
        fonts.set_sans_serif_family("DejaVu Sans");
        let tree = usvg::Tree::from_str(&svg, &options).map_err(|error| failed(&error))?;
        if self == Self::Pdf {
            let page = svg2pdf::PageOptions { dpi: POINTS_PER_INCH };
            return svg2pdf::to_pdf(&tree, svg2pdf::ConversionOptions::default(), page).map_err(|error| failed(&error));
        }
        let scale = DOTS_PER_INCH / POINTS_PER_INCH;
        let size = [tree.size().width(), tree.size().height()].map(|side| (scale * side).round() as u32);
        let mut dots = tiny_skia::Pixmap::new(size[0], size[1]).ok_or_else(|| failed(&"too many dots"))?;
        dots.fill(tiny_skia::Color::WHITE);
        resvg::render(&tree, tiny_skia::Transform::from_scale(scale, scale), &mut dots.as_mut());
        png_of(&dots).map_err(|error| failed(&error))
    }
}

/// Colours without opacity, as paper covers all of the picture, and the size of a dot.
fn png_of(dots: &tiny_skia::Pixmap) -> Result<Vec<u8>, png::EncodingError> {
    let mut content = Vec::new();
    let mut encoder = png::Encoder::new(&mut content, dots.width(), dots.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_compression(png::Compression::Best);
    let dots_per_metre = (DOTS_PER_INCH / 0.0254).round() as u32;
    encoder.set_pixel_dims(Some(png::PixelDimensions {
        xppu: dots_per_metre,
        yppu: dots_per_metre,
        unit: png::Unit::Meter,
    }));
    let colours: Vec<u8> = dots.pixels().iter().flat_map(|dot| [dot.red(), dot.green(), dot.blue()]).collect();
    encoder.write_header()?.write_image_data(&colours)?;
    Ok(content)
}
