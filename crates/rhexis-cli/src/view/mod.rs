//! `rhexis view`: serves the page that tears in a browser, on the loopback address alone.

mod server;

use super::{SceneArgs, Stop, document, say::say};
use clap::Args;
use rhexis_scene::mesh_file;
use serde::Serialize;
use server::Content;
use std::net::{Ipv4Addr, TcpListener};
use std::path::{Component, Path, PathBuf};
use std::process::Command;
use std::sync::Arc;

/// Folder of a page that comes with the program, beside it.
const BESIDE: &str = "rhexis-page";

/// Folder of the page in the checkout that this program was built from.
const CHECKOUT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../bindings/web/dist");

/// Script that builds [`CHECKOUT`].
const BUILDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../bindings/web/build.sh");

/// The file that tells the folder of the page from others.
const INDEX: &str = "page/index.html";

/// Maximum size of a file of the page \[bytes\].
const MAX_ASSET: u64 = 64 << 20;

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
    /// Folder of the built page [default: rhexis-page beside the program, else bindings/web/dist of its checkout].
    #[arg(long, value_name = "DIR")]
    assets: Option<PathBuf>,
    /// Build the page first, in the program's checkout: fetches npm's packages and the target wasm32-unknown-unknown where they are missing.
    #[arg(long, conflicts_with = "assets")]
    build: bool,
}

/// Page and files of the server.
struct Site {
    /// Folder of the page, without links.
    assets: PathBuf,
    /// Scene or mesh that the page opens first, as JSON, where one was named.
    start: Option<Arc<[u8]>>,
    /// The files that this names by their numbers.
    files: Vec<PathBuf>,
}

/// Scene or mesh that the page opens first.
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
    let site = Site::of(args)?;
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, args.port)).map_err(|error| {
        let what = format!("cannot serve on port {}: {error}", args.port);
        Stop::Failed(format!("{what}; choose another with --port, or --port 0 for any that is free"))
    })?;
    let port = listener.local_addr().map_err(|error| Stop::Failed(error.to_string()))?.port();
    say(&format!("the page is at http://127.0.0.1:{port}{}\nCtrl-C ends", site.index()))?;
    server::serve(&listener, port, move |path| site.find(path));
    Ok(())
}

impl Site {
    fn of(args: &ViewArgs) -> Result<Self, Stop> {
        // A scene is judged before the page is built for it.
        let (start, files) = match &args.scene {
            None => (None, Vec::new()),
            Some(scene) => {
                let (start, files) = if is_mesh(scene) { of_mesh(scene)? } else { of_scene(scene, &args.set)? };
                let start = serde_json::to_vec(&start).map_err(|error| Stop::Failed(error.to_string()))?;
                (Some(Arc::from(start)), files)
            }
        };
        let assets = match &args.assets {
            Some(folder) => folder.clone(),
            None if args.build => built()?,
            None => ready(),
        };
        let place = assets.join(INDEX);
        let missing = || {
            let how = "`rhexis view --build` makes it in a checkout, by Rust with the target wasm32-unknown-unknown and by npm; \
                       or give the folder of a built one with --assets";
            Stop::Failed(format!("the page is not there: {} is missing; {how}", place.display()))
        };
        let assets = assets.canonicalize().map_err(|_| missing())?;
        let site = Self { assets, start, files };
        site.asset(INDEX).filter(|index| index.is_file()).ok_or_else(missing)?;
        Ok(site)
    }

    /// Path of the page with its beginning.
    fn index(&self) -> String {
        let query = if self.start.is_some() { "?start=../start.json" } else { "" };
        format!("/{INDEX}{query}")
    }

    /// Content of a path.
    fn find(&self, path: &str) -> Option<Content> {
        let path = path.strip_prefix('/')?;
        if path.is_empty() {
            return Some(Content::Moved(self.index()));
        }
        if path == "start.json" {
            return self.start.clone().map(Content::Json);
        }
        if let Some(number) = path.strip_prefix("start/") {
            let file = self.files.get(number.parse::<usize>().ok()?)?;
            return Some(Content::File(file.clone(), kind(Path::new("")), mesh_file::MOST_BYTES));
        }
        let file = self.asset(path)?;
        let kind = kind(&file);
        Some(Content::File(file, kind, MAX_ASSET))
    }

    /// File of the page's folder; `None` for links that lead out of it.
    fn asset(&self, path: &str) -> Option<PathBuf> {
        let path = Path::new(path);
        let is_plain = path.components().all(|word| matches!(word, Component::Normal(_)));
        let file = is_plain.then(|| self.assets.join(path).canonicalize().ok())??;
        file.starts_with(&self.assets).then_some(file)
    }
}

/// Folder of the page that is ready, if any is.
fn ready() -> PathBuf {
    let program = std::env::current_exe().ok();
    let beside = program.and_then(|program| Some(program.parent()?.join(BESIDE)));
    beside.filter(|folder| folder.join(INDEX).is_file()).unwrap_or_else(|| PathBuf::from(CHECKOUT))
}

/// Folder of the checkout's page after a build.
fn built() -> Result<PathBuf, Stop> {
    if !Path::new(BUILDER).is_file() {
        let what =
            format!("the page is built in the checkout that this program was built from, where {BUILDER} is missing");
        return Err(Stop::Failed(format!("{what}; give the folder of a built one with --assets")));
    }
    say("bindings/web/build.sh builds the page, in some minutes")?;
    match Command::new("bash").args([BUILDER, "simd"]).status() {
        Ok(status) if status.success() => Ok(PathBuf::from(CHECKOUT)),
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
    // Files that are no regular ones, or too large, are refused here with their line.
    scene.check()?;
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn args(assets: &Path) -> ViewArgs {
        ViewArgs { scene: None, set: Vec::new(), port: 0, assets: Some(assets.to_owned()), build: false }
    }

    fn refusal(args: &ViewArgs) -> String {
        let Err(Stop::Failed(what)) = Site::of(args) else { panic!("served") };
        what
    }

    #[test]
    fn a_page_that_is_not_built_is_said_to_be_missing() {
        let folder = tempfile::tempdir().unwrap();
        for assets in [folder.path(), &folder.path().join("none")] {
            let what = refusal(&args(assets));
            assert!(what.contains(INDEX) && what.contains("view --build") && what.contains("--assets"), "{what}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_that_lead_out_of_the_page_are_not_followed() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let [page, secret] = ["site/page", "secret.js"].map(|name| folder.path().join(name));
        fs::create_dir_all(&page).unwrap();
        fs::write(&secret, "secret").unwrap();
        symlink(&secret, page.join("index.html")).unwrap();
        let args = args(&folder.path().join("site"));
        assert!(refusal(&args).contains(INDEX));

        fs::remove_file(page.join("index.html")).unwrap();
        fs::write(page.join("index.html"), "page").unwrap();
        symlink("index.html", page.join("inside.html")).unwrap();
        symlink(&secret, page.join("outside.js")).unwrap();
        symlink(folder.path(), page.join("folder")).unwrap();
        let site = Site::of(&args).map_err(|_| "refused").unwrap();
        assert!(site.find("/page/inside.html").is_some());
        for path in
            ["/page/outside.js", "/page/folder/secret.js", "/page/../../secret.js", "//", "/start.json", "/start/0"]
        {
            assert!(site.find(path).is_none(), "{path}");
        }
    }
}
