//! The part of HTTP/1.1 that one page needs: a request with a small body, one answer, end. Headers
//! are parsed by `httparse`, the parser of hyper.
//!
//! The page is one file: its styles and scripts are put in where its text names them.

use std::io;
use std::io::{ErrorKind, Read, Write};
use std::sync::LazyLock;

/// Headers and body are no longer than this, and of so many lines.
const LONGEST: usize = 16 * 1024;
const MOST_HEADERS: usize = 64;

/// A request.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PageRequest {
    pub method: String,
    /// Path and query, as they came.
    pub target: String,
    headers: Vec<(String, String)>,
    pub body: Vec<u8>,
}

impl PageRequest {
    /// Reads one.
    ///
    /// # Errors
    /// If the stream ends or fails, or what comes is no request or too long.
    pub fn read(stream: &mut impl Read) -> io::Result<Self> {
        let (mut text, mut chunk) = (Vec::new(), [0; 2048]);
        loop {
            let read = match stream.read(&mut chunk)? {
                0 => return Err(ErrorKind::UnexpectedEof.into()),
                read => read,
            };
            text.extend_from_slice(&chunk[..read]);
            if let Some((request, 0)) = Self::parse(&text)? {
                return Ok(request);
            }
            if text.len() > LONGEST {
                return Err(refuse("it is too long"));
            }
        }
    }

    /// The request, and how many bytes of its body are still missing; `None` while there are no
    /// whole headers.
    fn parse(text: &[u8]) -> io::Result<Option<(Self, usize)>> {
        let mut lines = [httparse::EMPTY_HEADER; MOST_HEADERS];
        let mut parsed = httparse::Request::new(&mut lines);
        let httparse::Status::Complete(start) = parsed.parse(text).map_err(io::Error::other)? else {
            return Ok(None);
        };
        let header = |line: &httparse::Header| {
            (line.name.to_ascii_lowercase(), String::from_utf8_lossy(line.value).trim().to_owned())
        };
        let request = Self {
            method: parsed.method.unwrap_or_default().to_owned(),
            target: parsed.path.unwrap_or_default().to_owned(),
            headers: parsed.headers.iter().map(header).collect(),
            body: Vec::new(),
        };
        let length = request.header("content-length").map_or(Ok(0), str::parse::<usize>);
        let length = length.map_err(|_| refuse("its length is no number"))?;
        if length > LONGEST || request.header("transfer-encoding").is_some() {
            return Err(refuse("its body is too long"));
        }
        let body = &text[start..];
        let body = &body[..body.len().min(length)];
        let missing = length - body.len();
        Ok(Some((Self { body: body.to_vec(), ..request }, missing)))
    }

    /// A header by its name in small letters.
    pub fn header(&self, name: &str) -> Option<&str> {
        self.headers.iter().find(|(own, _)| own == name).map(|(_, value)| value.as_str())
    }

    /// Path, and a value of the query by its key; nothing is escaped in ours.
    pub fn path(&self) -> &str {
        self.target.split('?').next().unwrap_or_default()
    }

    /// The value of a key of the query.
    pub fn query(&self, key: &str) -> Option<&str> {
        let (_, query) = self.target.split_once('?')?;
        query.split('&').filter_map(|pair| pair.split_once('=')).find(|(own, _)| *own == key).map(|(_, value)| value)
    }
}

/// Headers that forbid what no other page may do with ours: frame it, load from it, guess its type,
/// see its address.
const HEADERS: &str = "Content-Security-Policy: default-src 'none'; script-src 'unsafe-inline'; \
    style-src 'unsafe-inline'; img-src data:; connect-src 'self'; base-uri 'none'; form-action 'none'; \
    frame-ancestors 'none'\r\n\
    Cross-Origin-Resource-Policy: same-origin\r\nX-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\n\
    Cache-Control: no-store\r\nConnection: close\r\n";

/// Writes a whole answer.
pub fn answer(stream: &mut impl Write, status: &str, kind: &str, body: &[u8]) -> io::Result<()> {
    let length = body.len();
    let head = format!("HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\n{HEADERS}\r\n");
    stream.write_all(&[head.as_bytes(), body].concat())
}

/// Begins an answer that goes on with server-sent events.
pub fn answer_events(stream: &mut impl Write) -> io::Result<()> {
    stream.write_all(format!("HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\n{HEADERS}\r\n").as_bytes())
}

fn refuse(sentence: &str) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, sentence)
}

/// Every file that the page is made of, by its name in `{{…}}`.
const PARTS: [(&str, &str); 5] = [
    ("uPlot.min.css", include_str!("assets/uPlot.min.css")),
    ("page.css", include_str!("assets/page.css")),
    ("uPlot.iife.min.js", include_str!("assets/uPlot.iife.min.js")),
    ("charts.js", include_str!("assets/charts.js")),
    ("page.js", include_str!("assets/page.js")),
];

static PAGE: LazyLock<String> = LazyLock::new(|| {
    PARTS.iter().fold(include_str!("assets/page.html").to_owned(), |page, (name, text)| {
        page.replace(&format!("{{{{{name}}}}}"), text)
    })
});

/// The page.
pub fn page_text() -> &'static str {
    &PAGE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_in_pieces_is_one_request() {
        let text = "POST /t/command?a=1&b=two HTTP/1.1\r\nHost: localhost:1\r\nContent-Length: 5\r\n\r\nhello";
        for cut in 1..text.len() {
            let (first, second) = text.as_bytes().split_at(cut);
            let request = PageRequest::read(&mut first.chain(second)).unwrap();
            assert_eq!(
                (request.method.as_str(), request.path(), request.query("b")),
                ("POST", "/t/command", Some("two"))
            );
            assert_eq!((request.header("host"), request.body.as_slice()), (Some("localhost:1"), "hello".as_bytes()));
        }
    }

    #[test]
    fn what_is_too_long_or_no_request_is_refused() {
        let endless = std::iter::repeat_n(b"X: y\r\n".as_slice(), 10_000).flatten().copied().collect::<Vec<u8>>();
        let cases: [&[u8]; 5] = [
            b"\x16\x03\x01 hello",
            b"GET / HTTP/1.1\r\nHost",
            b"POST / HTTP/1.1\r\nContent-Length: 99999999\r\n\r\n",
            b"POST / HTTP/1.1\r\nContent-Length: -1\r\n\r\n",
            b"POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n",
        ];
        for case in cases {
            assert!(PageRequest::read(&mut &*case).is_err(), "{:?}", String::from_utf8_lossy(case));
        }
        assert!(PageRequest::read(&mut b"GET / HTTP/1.1\r\n".chain(&*endless)).is_err());
    }

    #[test]
    fn the_page_is_whole_and_loads_nothing() {
        let own = page_text();
        assert!(!own.contains("{{") || !PARTS.iter().any(|(name, _)| own.contains(&format!("{{{{{name}}}}}"))));
        for outside in ["src=", "@import", "url(", "<link rel=\"stylesheet\"", "import("] {
            assert!(!own.contains(outside), "{outside}");
        }
        // The browser would end the script there.
        assert_eq!(own.matches("</script>").count(), 3);
    }
}
