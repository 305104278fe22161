//! The server of the page: any program on the machine and any page in a browser may write to it, and none ends it or fills its memory.
#![cfg(target_os = "linux")]

use std::fs::{self, File};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Ipv4Addr, TcpStream};
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::thread::{scope, sleep};
use std::time::Duration;

const PROGRAM: &str = env!("CARGO_BIN_EXE_rhexis");

const MESH: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

struct Server {
    child: Child,
    port: u16,
    /// Open, or the server finds that nobody reads.
    _said: BufReader<ChildStdout>,
}

impl Drop for Server {
    fn drop(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }
}

impl Server {
    /// A server that has said its address, or the words of its refusal.
    fn start(program: &Path, folder: &Path, arguments: &[&str]) -> Result<Self, String> {
        let mut command = Command::new(program);
        command.current_dir(folder).args(["view", "--port", "0"]).args(arguments);
        let mut child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut said = BufReader::new(child.stdout.take().unwrap());
        let mut line = String::new();
        said.read_line(&mut line).unwrap();
        if let Some(rest) = line.strip_prefix("the page is at http://127.0.0.1:") {
            let port = rest.split('/').next().unwrap().parse().unwrap();
            return Ok(Self { child, port, _said: said });
        }
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(1));
        Err(String::from_utf8(output.stderr).unwrap())
    }

    /// A page of these files with a mesh.
    fn of(folder: &Path, files: &[(&str, u64)]) -> Self {
        page(folder, "page");
        fs::write(folder.join("mesh.obj"), MESH).unwrap();
        for (name, size) in files {
            File::create(folder.join(name)).unwrap().set_len(*size).unwrap();
        }
        Self::start(Path::new(PROGRAM), folder, &["mesh.obj", "--assets", "."]).unwrap()
    }

    /// A connection that has sent a request, with the server's port for `PORT`.
    fn send(&self, request: &[u8]) -> TcpStream {
        let mut stream = TcpStream::connect((Ipv4Addr::LOCALHOST, self.port)).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        let port = self.port.to_string();
        let pieces: Vec<&[u8]> = request.split(|byte| *byte == b'@').collect();
        // A server that has read enough may have left.
        _ = stream.write_all(&pieces.join(port.as_bytes()));
        stream
    }

    fn ask(&self, request: impl AsRef<[u8]>) -> Vec<u8> {
        for _ in 0..1000 {
            let mut answer = Vec::new();
            // The end of an answer may be that of a connection whose request was not read.
            _ = self.send(request.as_ref()).read_to_end(&mut answer);
            if !answer.starts_with(b"HTTP/1.1 503 ") {
                return answer;
            }
            sleep(Duration::from_millis(10));
        }
        panic!("all connections stay taken");
    }

    fn get(&self, path: &str) -> String {
        String::from_utf8(self.ask(plain(path))).unwrap()
    }

    /// Largest memory so far \[bytes\].
    fn peak(&self) -> u64 {
        let status = fs::read_to_string(format!("/proc/{}/status", self.child.id())).unwrap();
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
        line.trim().trim_end_matches(" kB").parse::<u64>().unwrap() << 10
    }
}

fn page(folder: &Path, text: &str) {
    fs::create_dir_all(folder.join("page")).unwrap();
    fs::write(folder.join("page/index.html"), text).unwrap();
}

/// A browser's request; `@` is the server's port.
fn plain(path: &str) -> String {
    format!("GET {path} HTTP/1.1\r\nHost: 127.0.0.1:@\r\nAccept: */*\r\n\r\n")
}

/// Requests with the beginning of their answers.
fn requests() -> Vec<(Vec<u8>, &'static str)> {
    let with = |head: &str| format!("{head}\r\n\r\n").into_bytes();
    let own = "Host: localhost:@";
    let mut list: Vec<(Vec<u8>, &str)> = [
        ("/", "302"),
        ("/page/index.html?start=../start.json", "200"),
        ("/page/large.js", "200"),
        ("/start.json", "200"),
        ("/start/0", "200"),
        ("//", "404"),
        ("//[", "404"),
        ("/start/1", "404"),
        ("/page", "404"),
        ("/page/none.js", "404"),
        ("/page/../../secret", "404"),
        ("/..%2fsecret\0", "404"),
    ]
    .map(|(path, status)| (plain(path).into_bytes(), status))
    .into();
    list.extend([
        (with("GET / HTTP/1.1\r\nHost: evil.example:@"), "403"),
        (with("GET / HTTP/1.1"), "400"),
        (with(&format!("GET / HTTP/1.1\r\n{own}\r\n{own}")), "400"),
        (with(&format!("GET http://evil.example/ HTTP/1.1\r\n{own}")), "400"),
        (with(&format!("POST / HTTP/1.1\r\n{own}\r\nContent-Length: 3\r\n\r\nabc")), "405"),
        (with(&format!("GET / HTTP/1.1\r\n{own}\r\nX: {}", "x".repeat(20 << 10))), "431"),
        (b"\xff\xfe\x00\x01\r\n\r\n".into(), "400"),
        (b"\r\n\r\n".into(), "400"),
    ]);
    list
}

#[test]
fn a_page_beside_the_program_is_served() {
    let program = Path::new(PROGRAM);
    let folder = tempfile::tempdir_in(program.parent().unwrap()).unwrap();
    let copy = folder.path().join(program.file_name().unwrap());
    fs::hard_link(program, &copy).unwrap();
    page(&folder.path().join("rhexis-page"), "beside");
    let server = Server::start(&copy, folder.path(), &[]).unwrap();
    assert!(server.get("/page/index.html").ends_with("\r\n\r\nbeside"));
    assert!(server.get("/").contains("\r\nLocation: /page/index.html\r\n"));
}

#[test]
fn the_page_begins_with_the_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::of(folder.path(), &[]);
    assert!(server.get("/").contains("\r\nLocation: /page/index.html?start=../start.json\r\n"));
    assert!(server.get("/start.json").contains(r#""mesh":{"name":"mesh.obj","at":"start/0"}"#));
    assert!(server.get("/start/0").ends_with(&format!("\r\n\r\n{MESH}")));
    let foreign = server.ask("GET /start/0 HTTP/1.1\r\nHost: evil.example\r\n\r\n");
    let foreign = String::from_utf8(foreign).unwrap();
    assert!(foreign.contains("this server is that of http://127.0.0.1:") && !foreign.contains("v 0 0 0"), "{foreign}");
}

#[test]
fn devices_and_pipes_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    page(folder.path(), "page");
    let at = |name: &str| folder.path().join(name);
    symlink("/dev/zero", at("zero.obj")).unwrap();
    assert!(Command::new("mkfifo").arg(at("pipe.obj")).status().unwrap().success());
    File::create(at("hole.obj")).unwrap().set_len(1 << 40).unwrap();
    let refused =
        |scene: &str| Server::start(Path::new(PROGRAM), folder.path(), &[scene, "--assets", "."]).err().unwrap();
    for (name, told) in [
        ("zero.obj", "not a regular file"),
        ("pipe.obj", "not a regular file"),
        ("hole.obj", "larger than the 1024 MB"),
        ("/dev/zero", "/dev/zero"),
    ] {
        let body = "[[bodies]]\nname = \"b\"\nmaterial = { young = 1, poisson = 0.3, thickness = 0.1 }\n";
        let text = format!("[scene]\nname = \"s\"\n[run]\ndt = 1\nsteps = 1\n{body}mesh = {{ file = \"{name}\" }}\n");
        fs::write(at("s.toml"), text).unwrap();
        let error = refused("s.toml");
        assert!(error.contains("s.toml:9:") && error.contains(name) && error.contains(told), "{error}");
        let error = refused(name);
        assert!(error.contains(name) && error.contains(told), "{error}");
    }

    // A file that becomes a device is told to the page.
    fs::write(at("mesh.obj"), MESH).unwrap();
    let server = Server::start(Path::new(PROGRAM), folder.path(), &["mesh.obj", "--assets", "."]).unwrap();
    fs::remove_file(at("mesh.obj")).unwrap();
    symlink("/dev/zero", at("mesh.obj")).unwrap();
    let answer = server.get("/start/0");
    assert!(
        answer.starts_with("HTTP/1.1 404") && answer.ends_with("\r\n\r\nmesh.obj cannot be read: not a regular file\n"),
        "{answer}"
    );
}

#[test]
fn a_thousand_requests_of_each_kind_leave_the_memory_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let size = 2 << 20;
    let server = Server::of(folder.path(), &[("page/large.js", size)]);
    let begin = server.peak();
    let ask = |(request, status): &(Vec<u8>, &str)| {
        for _ in 0..1000 {
            let answer = server.ask(request);
            let told = String::from_utf8_lossy(&answer[..answer.len().min(100)]);
            let asked = String::from_utf8_lossy(&request[..request.len().min(60)]);
            assert!(told.starts_with(&format!("HTTP/1.1 {status} ")), "{asked:?}: {told:?}");
        }
    };
    // Concurrently, as browsers do.
    let requests = requests();
    scope(|scope| requests.chunks(3).for_each(|kinds| drop(scope.spawn(|| kinds.iter().for_each(ask)))));
    for _ in 0..1000 {
        // Nothing, half a request, and a reader that leaves within the answer.
        drop(server.send(b""));
        drop(server.send(b"GET / HT"));
        _ = server.send(plain("/page/large.js").as_bytes()).read(&mut [0]);
    }
    let grown = server.peak() - begin;
    println!("{} kB at the start, {} kB more", begin >> 10, grown >> 10);
    assert!(grown <= 2 * size, "{grown} bytes");
}

#[test]
fn sixty_slow_readers_share_sixteen_connections_and_no_memory() {
    let folder = tempfile::tempdir().unwrap();
    let size = 64 << 20;
    let server = Server::of(folder.path(), &[("page/large.js", size)]);
    let begin = server.peak();
    let mut readers: Vec<TcpStream> = (0..60).map(|_| server.send(plain("/page/large.js").as_bytes())).collect();
    let told = readers.iter_mut().map(|reader| {
        let mut status = [0; 12];
        reader.read_exact(&mut status).unwrap();
        String::from_utf8(status.to_vec()).unwrap()
    });
    let told: Vec<String> = told.collect();
    let count = |status: &str| told.iter().filter(|told| told.ends_with(status)).count();
    assert_eq!((count("200"), count("503")), (16, 44), "{told:?}");
    let grown = server.peak() - begin;
    println!("{} kB at the start, {} kB more", begin >> 10, grown >> 10);
    assert!(grown <= size / 4, "{grown} bytes");

    // The connections are free again when the readers have left.
    drop(readers);
    assert!(server.get("/page/index.html").ends_with("page"));
}
