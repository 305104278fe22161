//! `rhexis view`: serves the page that tears in a browser, on the loopback address alone.

use super::{SceneArgs, Stop, document, say::say};
use clap::Args;
use rhexis_scene::mesh_file;
use serde::Serialize;
use std::fs;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::path::{Component, Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::time::Duration;

/// Where `bindings/web/build.sh` puts the page, in the checkout that this program was built from.
const BUILT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../bindings/web/dist");

/// What builds it.
const BUILDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../bindings/web/build.sh");

/// The file that tells the folder of the page from others.
const INDEX: &str = "page/index.html";

/// A connection that says nothing for so long is closed.
const PATIENCE: Duration = Duration::from_secs(10);

/// The most bytes of a request's head.
const MOST_HEAD: u64 = 16 << 10;

#[derive(Args)]
pub(super) struct ViewArgs {
    /// Name of a catalog scene, path of a scene file, or path of a mesh file to tear by hand [default: the page's own choice].
    #[arg(value_name = "SCENE|FILE")]
    scene: Option<String>,
    /// Change a value of the scene: dotted path, arrays by index, value as in TOML. May be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE", requires = "scene")]
    set: Vec<String>,
    /// Port; 0 takes any that is free.
    #[arg(long, value_name = "N", default_value_t = 8573)]
    port: u16,
    /// Folder of the built page [default: bindings/web/dist of the checkout, built first where it is missing].
    #[arg(long, value_name = "DIR")]
    assets: Option<PathBuf>,
}

/// What is served.
struct Site {
    assets: PathBuf,
    /// What the page begins with, as JSON, where a scene was named.
    start: Option<String>,
    /// The files that this names by their numbers.
    files: Vec<PathBuf>,
}

/// What the page begins with.
#[derive(Serialize)]
struct Start {
    scene: Option<String>,
    set: Vec<String>,
    files: Vec<Given>,
    mesh: Option<Given>,
}

/// A file, the name that the scene has for it and where the page finds it.
#[derive(Serialize)]
struct Given {
    name: String,
    at: String,
}

/// Serves until it is ended.
pub(super) fn view(args: &ViewArgs) -> Result<(), Stop> {
    let site = Arc::new(Site::of(args)?);
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, args.port)).map_err(|error| {
        let what = format!("cannot serve on port {}: {error}", args.port);
        Stop::Failed(format!("{what}; choose another with --port, or --port 0 for any that is free"))
    })?;
    let port = listener.local_addr().map_err(|error| Stop::Failed(error.to_string()))?.port();
    let query = if site.start.is_some() { "?start=../start.json" } else { "" };
    say(&format!("the page is at http://127.0.0.1:{port}/{INDEX}{query}\nCtrl-C ends"))?;
    for stream in listener.incoming().flatten() {
        let site = Arc::clone(&site);
        // A browser opens several connections and leaves some waiting. One that breaks off is asked again.
        std::thread::spawn(move || _ = site.answer(&stream, port));
    }
    Ok(())
}

impl Site {
    fn of(args: &ViewArgs) -> Result<Self, Stop> {
        // A scene is judged before the page is built for it.
        let (start, files) = match &args.scene {
            None => (None, Vec::new()),
            Some(scene) => {
                let (start, files) = if is_mesh(scene) { of_mesh(scene)? } else { of_scene(scene, &args.set)? };
                (Some(serde_json::to_string(&start).map_err(|error| Stop::Failed(error.to_string()))?), files)
            }
        };
        let assets = args.assets.clone().map_or_else(built, Ok)?;
        if !assets.join(INDEX).is_file() {
            let place = assets.join(INDEX);
            let how = "build it by `bindings/web/build.sh` in a checkout, which needs npm and the target \
                       wasm32-unknown-unknown, or give the folder of a built one with --assets";
            return Err(Stop::Failed(format!("the page is not there: {} is missing; {how}", place.display())));
        }
        Ok(Self { assets, start, files })
    }

    /// Answers one request.
    fn answer(&self, stream: &TcpStream, port: u16) -> io::Result<()> {
        stream.set_read_timeout(Some(PATIENCE))?;
        let mut lines = BufReader::new(stream.take(MOST_HEAD)).lines();
        let Some(first) = lines.next() else { return Ok(()) };
        let first = first?;
        let head: Vec<String> = lines.map_while(Result::ok).take_while(|line| !line.is_empty()).collect();
        let mut words = first.split(' ');
        let (method, target) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
        if method != "GET" {
            return respond(stream, "405 Method Not Allowed", "text/plain", b"only GET\n");
        }
        // A page of another site that has its name point here is refused.
        let host = head.iter().find_map(|line| line.to_ascii_lowercase().strip_prefix("host:").map(str::to_owned));
        let host = host.unwrap_or_default();
        if ![format!("127.0.0.1:{port}"), format!("localhost:{port}")].contains(&host.trim().to_owned()) {
            return respond(stream, "403 Forbidden", "text/plain", b"not this host\n");
        }
        let path = target.split('?').next().unwrap_or_default();
        match self.find(path) {
            Some((bytes, kind)) => respond(stream, "200 OK", kind, &bytes),
            None => respond(stream, "404 Not Found", "text/plain", b"not found\n"),
        }
    }

    /// The content and its type.
    fn find(&self, path: &str) -> Option<(Vec<u8>, &'static str)> {
        let path = if path == "/" { INDEX } else { path.trim_start_matches('/') };
        if path == "start.json" {
            return Some((self.start.clone()?.into_bytes(), "application/json"));
        }
        if let Some(number) = path.strip_prefix("start/") {
            let file = self.files.get(number.parse::<usize>().ok()?)?;
            return Some((fs::read(file).ok()?, "application/octet-stream"));
        }
        let path = Path::new(path);
        if !path.components().all(|word| matches!(word, Component::Normal(_))) {
            return None;
        }
        Some((fs::read(self.assets.join(path)).ok()?, kind(path)))
    }
}

/// The folder of the checkout's page, which is built where it is missing and there is a checkout.
fn built() -> Result<PathBuf, Stop> {
    let assets = PathBuf::from(BUILT);
    if assets.join(INDEX).is_file() || !Path::new(BUILDER).is_file() {
        return Ok(assets);
    }
    say("the page is not built yet: bindings/web/build.sh does it now, once, in some minutes")?;
    let status = Command::new("bash").args([BUILDER, "simd"]).status();
    match status {
        Ok(status) if status.success() => Ok(assets),
        Ok(_) => Err(Stop::Failed("the page cannot be built: bindings/web/build.sh has said why".to_owned())),
        Err(error) => Err(Stop::Failed(format!("the page cannot be built: bash {BUILDER}: {error}"))),
    }
}

fn is_mesh(name: &str) -> bool {
    let extension = Path::new(name).extension().unwrap_or_default().to_string_lossy().to_lowercase();
    mesh_file::EXTENSIONS.contains(&extension.as_str())
}

fn of_mesh(path: &str) -> Result<(Start, Vec<PathBuf>), Stop> {
    // Judged here, where the message is seen at once.
    mesh_file::read_with(Path::new(path), &mesh_file::Reading { repair: true, ..mesh_file::Reading::default() })
        .map_err(|error| Stop::Failed(error.to_string()))?;
    let name = Path::new(path).file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mesh = Some(Given { name, at: "start/0".to_owned() });
    Ok((Start { scene: None, set: Vec::new(), files: Vec::new(), mesh }, vec![PathBuf::from(path)]))
}

fn of_scene(name: &str, set: &[String]) -> Result<(Start, Vec<PathBuf>), Stop> {
    let document = document(&SceneArgs { scene: name.to_owned(), set: set.to_vec() })?;
    let text = document.text().to_owned();
    let scene = document.scene()?;
    let files = scene.data_files();
    let folder = scene.path().and_then(Path::parent).unwrap_or(Path::new(""));
    let given = files.iter().enumerate().map(|(i, path)| {
        let name = path.strip_prefix(folder).unwrap_or(path).to_string_lossy().into_owned();
        Given { name, at: format!("start/{i}") }
    });
    let files_given = given.collect();
    Ok((Start { scene: Some(text), set: set.to_vec(), files: files_given, mesh: None }, files))
}

fn kind(path: &Path) -> &'static str {
    match path.extension().and_then(|extension| extension.to_str()).unwrap_or_default() {
        "html" => "text/html; charset=utf-8",
        "js" => "text/javascript; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "wasm" => "application/wasm",
        "json" => "application/json",
        _ => "application/octet-stream",
    }
}

fn respond(mut stream: &TcpStream, status: &str, kind: &str, bytes: &[u8]) -> io::Result<()> {
    let fixed = "Cache-Control: no-cache\r\nX-Content-Type-Options: nosniff\r\nConnection: close";
    write!(stream, "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\n{fixed}\r\n\r\n", bytes.len())?;
    stream.write_all(bytes)?;
    stream.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn site(folder: &Path) -> Site {
        fs::create_dir(folder.join("page")).unwrap();
        fs::write(folder.join(INDEX), "page").unwrap();
        fs::write(folder.join("mesh.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
        let args = ViewArgs {
            scene: Some(folder.join("mesh.obj").to_string_lossy().into_owned()),
            set: Vec::new(),
            port: 0,
            assets: Some(folder.to_owned()),
        };
        Site::of(&args).map_err(|_| "refused").unwrap()
    }

    fn ask(site: &Arc<Site>, request: &str) -> String {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let port = listener.local_addr().unwrap().port();
        let mut client = TcpStream::connect((Ipv4Addr::LOCALHOST, port)).unwrap();
        client.write_all(request.replace("PORT", &port.to_string()).as_bytes()).unwrap();
        let (stream, _) = listener.accept().unwrap();
        site.answer(&stream, port).unwrap();
        drop(stream);
        let mut answer = String::new();
        client.read_to_string(&mut answer).unwrap();
        answer
    }

    #[test]
    fn the_page_and_the_mesh_are_served_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let site = Arc::new(site(folder.path()));
        let get = |path: &str| ask(&site, &format!("GET {path} HTTP/1.1\r\nHost: 127.0.0.1:PORT\r\n\r\n"));
        assert!(get("/page/index.html?start=../start.json").ends_with("\r\n\r\npage"));
        assert!(get("/").ends_with("\r\n\r\npage"));
        assert!(get("/start.json").contains(r#""mesh":{"name":"mesh.obj","at":"start/0"}"#));
        assert!(get("/start/0").ends_with("f 1 2 3\n"));
        for path in ["/start/1", "/../secret", "/page/../../secret", "//etc/passwd", "/page/none.js"] {
            assert!(get(path).starts_with("HTTP/1.1 404"), "{path}");
        }
    }

    #[test]
    fn other_hosts_and_methods_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let site = Arc::new(site(folder.path()));
        assert!(ask(&site, "GET / HTTP/1.1\r\nHost: evil.example\r\n\r\n").starts_with("HTTP/1.1 403"));
        assert!(ask(&site, "POST / HTTP/1.1\r\nHost: 127.0.0.1:PORT\r\n\r\n").starts_with("HTTP/1.1 405"));
    }

    #[test]
    fn a_page_that_is_not_built_is_said_to_be_missing() {
        let folder = tempfile::tempdir().unwrap();
        let assets = Some(folder.path().to_owned());
        let args = ViewArgs { scene: None, set: Vec::new(), port: 0, assets };
        let Err(Stop::Failed(what)) = Site::of(&args) else { panic!("served") };
        assert!(what.contains("build.sh") && what.contains("--assets"), "{what}");
    }
}
