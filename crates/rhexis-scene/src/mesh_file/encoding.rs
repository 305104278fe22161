//! What stands before the format: byte-order marks, other encodings of text, and files that are something else.

use super::fault::Fault;

/// The bytes without their byte-order mark; text in UTF-16 becomes UTF-8.
///
/// # Errors
/// For a pointer, a web page or an archive in place of the mesh.
pub(super) fn unwrapped(mut bytes: Vec<u8>) -> Result<Vec<u8>, Fault> {
    if bytes.starts_with(b"\xef\xbb\xbf") {
        bytes.drain(..3);
    }
    if let Some(wide) = bytes.strip_prefix(b"\xff\xfe") {
        bytes = narrow(wide, u16::from_le_bytes);
    } else if let Some(wide) = bytes.strip_prefix(b"\xfe\xff") {
        bytes = narrow(wide, u16::from_be_bytes);
    }
    let head = bytes.trim_ascii_start();
    let head = head[..head.len().min(64)].to_ascii_lowercase();
    let signs: [(&[u8], &str); 6] = [
        (b"version https://git-lfs.github.com/spec", "a Git LFS pointer: fetch the file itself (`git lfs pull`)"),
        (b"/annex/objects/", "a git-annex pointer: fetch the file itself (`git annex get`)"),
        (b"<!doctype html", "a web page: download the file itself (its raw form)"),
        (b"<html", "a web page: download the file itself (its raw form)"),
        (b"\x1f\x8b", "compressed with gzip: unpack it first"),
        (b"pk\x03\x04", "a ZIP archive: unpack it first"),
    ];
    match signs.iter().find(|(sign, _)| head.starts_with(sign)) {
        Some((_, what)) => Err(Fault::new(what)),
        None => Ok(bytes),
    }
}

fn narrow(wide: &[u8], unit: fn([u8; 2]) -> u16) -> Vec<u8> {
    let units = wide.as_chunks::<2>().0.iter().map(|pair| unit(*pair));
    char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect::<String>().into_bytes()
}

/// Text of any 8-bit encoding with a line feed at the end of each line: what is no UTF-8 is taken as Latin-1.
pub(super) fn text(bytes: Vec<u8>) -> String {
    let text = match String::from_utf8(bytes) {
        Ok(text) => text,
        Err(other) => other.as_bytes().iter().map(|&byte| char::from(byte)).collect(),
    };
    if text.contains('\r') { text.replace("\r\n", "\n").replace('\r', "\n") } else { text }
}

/// Line feeds in place of carriage returns, in text that is kept as bytes.
pub(super) fn line_feeds(bytes: Vec<u8>) -> Vec<u8> {
    if !bytes.contains(&b'\r') {
        return bytes;
    }
    let mut out = Vec::with_capacity(bytes.len());
    for (place, &byte) in bytes.iter().enumerate() {
        match byte {
            b'\r' if bytes.get(place + 1) == Some(&b'\n') => {}
            b'\r' => out.push(b'\n'),
            byte => out.push(byte),
        }
    }
    out
}

/// The first `count` lines, whatever ends them.
pub(super) fn first_lines(bytes: &[u8], count: usize) -> Vec<String> {
    let head = &bytes[..bytes.len().min(4096)];
    let text: String = head.iter().map(|&byte| char::from(byte)).collect();
    text.replace("\r\n", "\n").split(['\n', '\r']).take(count).map(str::to_owned).collect()
}

/// A number as programs print it, and as the array library of Python wraps it.
pub(super) fn number(word: &str) -> Option<f64> {
    word.parse().ok().or_else(|| {
        let inner = word.strip_suffix(')')?.split_once('(')?.1;
        inner.parse().ok()
    })
}
