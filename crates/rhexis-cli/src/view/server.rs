//! A server of files for browsers on this machine: its hosts, connections, sizes and times are bounded.

use rhexis::internal::source;
use std::io::{self, BufRead, BufReader, Cursor, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::path::PathBuf;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

/// Maximum concurrent connections.
const MAX_CONNECTIONS: usize = 16;

/// Maximum bytes of a request's head.
const MAX_HEAD: u64 = 16 << 10;

/// Time for a request's head, and for each [`PIECE`] of an answer.
const PATIENCE: Duration = Duration::from_secs(20);

/// Bytes of an answer that a reader takes within [`PATIENCE`].
const PIECE: u64 = 16 << 20;

/// Time for a refused request to end.
const LINGER: Duration = Duration::from_secs(1);

/// Pause after a connection that the system could not hand over.
const PAUSE: Duration = Duration::from_millis(10);

/// Header lines of every answer.
const FIELDS: &str = "Cache-Control: no-cache\r\nX-Content-Type-Options: nosniff\r\nCross-Origin-Resource-Policy: same-origin\r\nConnection: close";

/// Names of this machine in a request's `Host`.
const HOSTS: [&str; 3] = ["127.0.0.1", "localhost", "[::1]"];

/// Content of a path.
pub(super) enum Content {
    /// Another path.
    Moved(String),
    /// Text in JSON.
    Json(Arc<[u8]>),
    /// Regular file with its media type and its maximum size \[bytes\].
    File(PathBuf, &'static str, u64),
}

/// Response to a request.
struct Answer {
    status: &'static str,
    /// Header line that depends on the content.
    field: String,
    size: u64,
    body: Box<dyn Read>,
}

impl Answer {
    fn text(status: &'static str, field: &str, text: impl AsRef<[u8]> + 'static) -> Self {
        Self { status, field: field.to_owned(), size: text.as_ref().len() as u64, body: Box::new(Cursor::new(text)) }
    }

    /// Refusal with a sentence for its reader.
    fn refusal(status: &'static str, why: &str) -> Self {
        Self::text(status, "Content-Type: text/plain; charset=utf-8", format!("{why}\n"))
    }

    fn of(content: Content) -> Self {
        match content {
            Content::Moved(place) => Self::text("302 Found", &format!("Location: {place}"), ""),
            Content::Json(text) => Self::text("200 OK", "Content-Type: application/json", text),
            Content::File(file, kind, most) => match source::open(&file, most) {
                Ok((file, size)) => {
                    let body = Box::new(file.take(size));
                    Self { status: "200 OK", field: format!("Content-Type: {kind}"), size, body }
                }
                Err(error) => {
                    let name = file.file_name().unwrap_or_default().display();
                    Self::refusal("404 Not Found", &format!("{name} cannot be read: {error}"))
                }
            },
        }
    }

    fn send(mut self, client: &mut Client) -> io::Result<()> {
        let (status, field, size) = (self.status, self.field, self.size);
        let head = format!("HTTP/1.1 {status}\r\n{field}\r\nContent-Length: {size}\r\n{FIELDS}\r\n\r\n");
        client.write_all(head.as_bytes())?;
        io::copy(&mut self.body, client)?;
        client.stream.shutdown(Shutdown::Write)
    }
}

/// Connection whose reads and writes fail after a deadline.
struct Client<'a> {
    stream: &'a TcpStream,
    until: Instant,
}

impl Client<'_> {
    fn left(&self) -> io::Result<Option<Duration>> {
        let left = self.until.saturating_duration_since(Instant::now());
        if left.is_zero() { Err(io::ErrorKind::TimedOut.into()) } else { Ok(Some(left)) }
    }
}

impl Read for Client<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.stream.set_read_timeout(self.left()?)?;
        self.stream.read(buffer)
    }
}

impl Write for Client<'_> {
    fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
        self.stream.set_write_timeout(self.left()?)?;
        self.stream.write(buffer)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.stream.flush()
    }
}

/// Serves the contents that `find` has for paths, until the program ends.
pub(super) fn serve<F>(listener: &TcpListener, port: u16, find: F)
where
    F: Fn(&str) -> Option<Content> + Send + Sync + 'static,
{
    let find = Arc::new(find);
    for stream in listener.incoming() {
        let Ok(stream) = stream else {
            thread::sleep(PAUSE);
            continue;
        };
        // Each connection holds one.
        if Arc::strong_count(&find) > MAX_CONNECTIONS {
            // A reader that has left needs no answer.
            _ = turn_away(&stream);
            continue;
        }
        let find = Arc::clone(&find);
        // Without a thread the connection is closed, and a reader asks again.
        _ = thread::Builder::new().spawn(move || _ = answer(&stream, port, &*find, PATIENCE));
    }
}

/// Refuses a connection without waiting for its reader.
fn turn_away(stream: &TcpStream) -> io::Result<()> {
    stream.set_nonblocking(true)?;
    let mut client = Client { stream, until: Instant::now() + LINGER };
    let many = format!("{MAX_CONNECTIONS} connections are open, which is the most: ask again later");
    Answer::refusal("503 Service Unavailable", &many).send(&mut client)?;
    discard(&mut client)
}

/// Answers the request of a connection.
fn answer(
    stream: &TcpStream,
    port: u16,
    find: &impl Fn(&str) -> Option<Content>,
    patience: Duration,
) -> io::Result<()> {
    let mut client = Client { stream, until: Instant::now() + patience };
    let answer = head(&mut client).and_then(|head| {
        let path = path(&head, port)?;
        let none = || Answer::refusal("404 Not Found", &format!("{path} is not served"));
        Ok(Answer::of(find(path).ok_or_else(none)?))
    });
    let answer = answer.unwrap_or_else(|refusal| refusal);
    let pieces = u32::try_from(answer.size.div_ceil(PIECE)).unwrap_or(u32::MAX).max(1);
    client.until = Instant::now() + patience.saturating_mul(pieces);
    answer.send(&mut client)?;
    client.until = Instant::now() + LINGER;
    discard(&mut client)
}

/// Reads the rest of a request: the system withdraws an answer to bytes that are never read.
fn discard(client: &mut Client) -> io::Result<()> {
    io::copy(&mut client.take(MAX_HEAD), &mut io::sink()).map(drop)
}

/// Reads the lines of a request's head.
fn head(client: &mut Client) -> Result<Vec<String>, Answer> {
    let mut bytes = client.take(MAX_HEAD);
    let mut head = Vec::new();
    for line in BufReader::new(&mut bytes).lines() {
        match line {
            Ok(line) if line.is_empty() => return Ok(head),
            Ok(line) => head.push(line),
            Err(error) if error.kind() == io::ErrorKind::InvalidData => {
                return Err(Answer::refusal("400 Bad Request", "the request is not text"));
            }
            Err(_) => return Err(Answer::refusal("408 Request Timeout", "the request has not come to its end")),
        }
    }
    if bytes.limit() > 0 {
        return Err(Answer::refusal("400 Bad Request", "the request ends within its head"));
    }
    let long = format!("the request's head is longer than {} kB", MAX_HEAD >> 10);
    Err(Answer::refusal("431 Request Header Fields Too Large", &long))
}

/// Path that a request to this server asks for.
fn path(head: &[String], port: u16) -> Result<&str, Answer> {
    let words: Vec<&str> = head.first().map_or("", String::as_str).split(' ').collect();
    let [method, target, "HTTP/1.0" | "HTTP/1.1"] = words[..] else {
        return Err(Answer::refusal("400 Bad Request", "the request is not of HTTP/1.1"));
    };
    let fields = head[1..].iter().filter_map(|line| line.split_once(':'));
    let mut hosts = fields.filter(|(name, _)| name.eq_ignore_ascii_case("host")).map(|(_, host)| host.trim());
    let (Some(host), None) = (hosts.next(), hosts.next()) else {
        return Err(Answer::refusal("400 Bad Request", "the request does not name one host"));
    };
    // A page of another site may have its name lead here.
    if !is_own(host, port) {
        let whose = format!("this server is that of http://127.0.0.1:{port} and of http://localhost:{port} alone");
        return Err(Answer::refusal("403 Forbidden", &whose));
    }
    if method != "GET" {
        return Err(Answer::refusal("405 Method Not Allowed", "only GET is answered"));
    }
    let path = target.split('?').next().unwrap_or_default();
    if path.starts_with('/') {
        Ok(path)
    } else {
        Err(Answer::refusal("400 Bad Request", "the path does not begin with /"))
    }
}

/// Whether a request's `Host` is this server; browsers leave out port 80.
fn is_own(host: &str, port: u16) -> bool {
    let name = host.strip_suffix(&format!(":{port}")).or((port == 80).then_some(host));
    name.is_some_and(|name| HOSTS.iter().any(|own| own.eq_ignore_ascii_case(name)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::Ipv4Addr;

    #[test]
    fn a_host_is_this_machine_with_the_port_which_80_may_lack() {
        for host in ["127.0.0.1:8573", "localhost:8573", "LocalHost:8573", "[::1]:8573"] {
            assert!(is_own(host, 8573) && !is_own(host, 8574) && !is_own(host, 80), "{host}");
        }
        for host in ["127.0.0.1", "localhost", "[::1]", "localhost:80"] {
            assert!(is_own(host, 80) && !is_own(host, 8573), "{host}");
        }
        for host in ["", ":80", "evil.example", "evil.example:80", "localhost.evil.example", "127.0.0.1:80:80", "::1"] {
            assert!(!is_own(host, 80), "{host}");
        }
    }

    /// A file of 64 MB that takes no room on the disk, and a connection with this request that reads nothing.
    fn asked(request: &str) -> io::Result<()> {
        let folder = tempfile::tempdir()?;
        let place = folder.path().join("large");
        std::fs::File::create(&place)?.set_len(64 << 20)?;
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
        let port = listener.local_addr()?.port();
        let mut client = TcpStream::connect((Ipv4Addr::LOCALHOST, port))?;
        client.write_all(request.replace("PORT", &port.to_string()).as_bytes())?;
        let find = |_: &str| Some(Content::File(place.clone(), "text/plain", 64 << 20));
        answer(&listener.accept()?.0, port, &find, Duration::from_millis(50))
    }

    #[test]
    fn who_does_not_read_is_left() {
        let error = asked("GET / HTTP/1.1\r\nHost: localhost:PORT\r\n\r\n").unwrap_err();
        assert!(matches!(error.kind(), io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock), "{error}");
    }
}
