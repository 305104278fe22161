//! `rhexis render`: pictures, film strips and films of a run or of a scene.

mod circle;
mod film;
mod frames;
mod moments;

use crate::output::file;
use crate::output::picture::{Drawn, Look, Sheet, View};
use crate::say::say;
use crate::{Stop, kept, outputs};
use clap::Args;
use film::Picture;
use moments::Wanted;
use rhexis::frame::{BodyFrame, SolidFrame};
use std::path::{Path, PathBuf};
use tiny_skia::Pixmap;

#[derive(Args)]
pub(super) struct RenderArgs {
    /// Output directory of `rhexis run` with its frames; or else a catalog scene or a scene file, which is run for it.
    #[arg(value_name = "RUN_DIR|SCENE")]
    source: String,
    /// Change a value of the scene, as in `rhexis run`. May be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Views, side by side: auto, top (along the axis of the outer rim), front, side, oblique, perspective.
    #[arg(long, value_name = "VIEW,…", value_delimiter = ',', default_value = "auto", value_parser = view)]
    view: Vec<Looks>,
    /// A film strip: so many moments side by side, a row per view.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=64))]
    strip: Option<u16>,
    /// A film of so many moments, as animated PNG.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(2..=300), conflicts_with_all = ["strip", "frames"])]
    film: Option<u16>,
    /// So many numbered pictures in a directory, and the line that makes a film of them.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(2..=1000), conflicts_with = "strip")]
    frames: Option<u16>,
    /// The moments nearest to these times \[ms\] in place of N moments or of the last one.
    #[arg(long, value_name = "MS,…", value_delimiter = ',', value_parser = time, conflicts_with_all = ["strip", "film", "frames"])]
    at: Vec<f64>,
    /// The file, with `--frames` the directory [default: in the run's directory, or in `out`].
    #[arg(long, value_name = "PATH")]
    out: Option<PathBuf>,
    /// Width of one view \[px\] [default: 720, of several side by side 420].
    #[arg(long, value_name = "PX", value_parser = clap::value_parser!(u32).range(120..=3000))]
    size: Option<u32>,
    /// Pictures per second of a film.
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = clap::value_parser!(u16).range(1..=60))]
    fps: u16,
    /// A circle of this diameter \[mm\] about the axis: where a rhexis is meant to go.
    #[arg(long, value_name = "MM", value_parser = above_zero)]
    circle: Option<f64>,
    /// Opacity of what lies turned over, 0 to 1: below 1 what is beneath the flap is seen.
    #[arg(long, value_name = "PART", default_value_t = 1.0, value_parser = part)]
    flap_opacity: f64,
    /// No edges of triangles.
    #[arg(long)]
    no_mesh_lines: bool,
    /// No strokes along the fibres.
    #[arg(long)]
    no_fibres: bool,
    /// The tips with their polar curves (of a scene; frames do not have them).
    #[arg(long)]
    tips: bool,
    /// Neither title nor captions nor colour bar: the body with its scale bar.
    #[arg(long)]
    bare: bool,
    /// Number of steps at the most, of a scene.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=rhexis_scene::MOST_STEPS))]
    steps: Option<u64>,
    /// No progress bar.
    #[arg(long)]
    quiet: bool,
}

pub(super) const EXAMPLES: &str = "\
Examples:
  rhexis render out/capsulorhexis --view top,side,perspective
  rhexis render out/capsulorhexis --view top --circle 5.25 --flap-opacity 0.5 --no-mesh-lines
  rhexis render out/capsulorhexis --strip 5 --view top,perspective
  rhexis render capsulorhexis --at 2600,7900,13200 --set bodies.0.mesh.cap.triangles=1500
  rhexis render out/capsulorhexis --film 40 --view perspective --size 440 --no-mesh-lines
  rhexis render out/capsulorhexis --frames 60 --size 1000

Of a run's directory it shows the frames that were written (output.frames); a scene is run in memory, and nothing but the picture is
written. All moments have one frame and one scale of colours. Pieces below a twentieth of the body's area set no frame: chips may fly out.";

/// What a name of a view means.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Looks {
    At(View),
    /// Along the axis of the outer rim.
    Top,
}

fn view(name: &str) -> Result<Looks, String> {
    let oblique = |azimuth, elevation| Looks::At(View::Oblique { azimuth, elevation });
    Ok(match name {
        "auto" => Looks::At(View::Auto),
        "top" => Looks::Top,
        "front" => oblique(-90.0, 0.0),
        "side" => oblique(0.0, 0.0),
        "oblique" => oblique(-70.0, 50.0),
        "perspective" => Looks::At(View::Perspective { azimuth: -70.0, elevation: 40.0 }),
        _ => return Err("it is one of auto, top, front, side, oblique, perspective".to_owned()),
    })
}

fn above_zero(text: &str) -> Result<f64, String> {
    let value: Option<f64> = text.parse().ok();
    value.filter(|value| *value > 0.0 && value.is_finite()).ok_or_else(|| "it must be a number above 0".to_owned())
}

fn time(text: &str) -> Result<f64, String> {
    let value: Option<f64> = text.parse().ok();
    value.filter(|value| value.is_finite()).ok_or_else(|| "it must be a time in ms".to_owned())
}

fn part(text: &str) -> Result<f64, String> {
    let value: Option<f64> = text.parse().ok();
    value.filter(|value| (0.0..=1.0).contains(value)).ok_or_else(|| "it must be from 0 to 1".to_owned())
}

/// All bodies at one moment, as one.
#[derive(Clone, Debug, Default)]
struct Moment {
    /// \[ms\].
    time: f64,
    body: BodyFrame,
    solids: Vec<SolidFrame>,
}

impl Moment {
    fn drawn(&self, caption: String) -> Drawn<'_> {
        Drawn { body: &self.body, solids: &self.solids, caption }
    }
}

/// Bodies as one, with what is drawn: many moments are in memory at once.
fn together(bodies: Vec<BodyFrame>) -> BodyFrame {
    let mut bodies = bodies.into_iter();
    let first = bodies.next().unwrap_or_default();
    let BodyFrame { name, positions, rest_positions, triangles, principal_stress, fibres, tips, .. } = first;
    let drawn = BodyFrame {
        name,
        positions,
        rest_positions,
        triangles,
        principal_stress,
        fibres,
        tips,
        ..BodyFrame::default()
    };
    let mut whole = drawn;
    for body in bodies {
        let first = whole.positions.len() as u32;
        whole.triangles.extend(body.triangles.iter().map(|corners| corners.map(|v| v + first)));
        whole.positions.extend(body.positions);
        whole.rest_positions.extend(body.rest_positions);
        whole.principal_stress.extend(body.principal_stress);
        whole.fibres.extend(body.fibres);
        whole.tips.extend(body.tips);
    }
    whole
}

/// Draws what is asked for.
pub(super) fn render(args: &RenderArgs) -> Result<(), Stop> {
    let wanted = wanted(args);
    let source = Path::new(&args.source);
    let (title, moments, home) = if source.is_dir() {
        if !args.set.is_empty() || args.steps.is_some() || args.tips {
            let what = "--set, --steps and --tips are for a scene; a run's directory has its frames as they are";
            return Err(Stop::Usage(what.to_owned()));
        }
        (name_of(source), moments::of_run(source, &wanted)?, source.to_owned())
    } else {
        let (name, moments) = moments::of_scene(args, &wanted)?;
        let home = PathBuf::from("out").join(crate::run::file_name(&name));
        (name, moments, home)
    };
    let sheet = sheet(args, &moments)?;
    let (kind, default) = kind(args, &moments);
    let out = args.out.clone().unwrap_or_else(|| home.join(default));
    if kind != Kind::Frames {
        outputs::spare(&out, b"\x89PNG\r\n\x1a\n", "picture")?;
    }
    let folder = if kind == Kind::Frames { Some(out.as_path()) } else { out.parent() };
    if let Some(folder) = folder.filter(|folder| !folder.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder).map_err(|error| {
            Stop::Failed(format!("cannot make {}: {error}; choose another --out", folder.display()))
        })?;
    }
    match kind {
        Kind::Still => still(&sheet, &moments, &title, &out),
        Kind::Film => film(args, &sheet, &moments, &title, &out),
        Kind::Frames => numbered(args, &sheet, &moments, &title, &out),
    }
}

/// What is written.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Still,
    Film,
    Frames,
}

fn kind(args: &RenderArgs, moments: &[Moment]) -> (Kind, &'static str) {
    match (args.film.is_some(), args.frames.is_some(), moments.len()) {
        (true, ..) => (Kind::Film, "film.png"),
        (_, true, _) => (Kind::Frames, "film"),
        (.., 1) => (Kind::Still, "render.png"),
        _ => (Kind::Still, "strip.png"),
    }
}

fn wanted(args: &RenderArgs) -> Wanted {
    match args.film.or(args.frames).or(args.strip) {
        _ if !args.at.is_empty() => Wanted::At(args.at.clone()),
        count => Wanted::Spread(usize::from(count.unwrap_or(1))),
    }
}

/// What a run's directory calls its scene.
fn name_of(run: &Path) -> String {
    let text = kept::text(&run.join("report.json")).unwrap_or_default();
    let report: Option<serde_json::Value> = serde_json::from_str(&text).ok();
    let named = report.and_then(|report| report["scene"].as_str().map(str::to_owned));
    named.unwrap_or_else(|| run.file_name().unwrap_or_default().to_string_lossy().into_owned())
}

fn sheet(args: &RenderArgs, moments: &[Moment]) -> Result<Sheet, Stop> {
    let bodies: Vec<&BodyFrame> = moments.iter().map(|moment| &moment.body).collect();
    let axis = bodies.first().and_then(|body| circle::axis(body));
    let views: Vec<View> = args
        .view
        .iter()
        .map(|looks| match (looks, &axis) {
            (Looks::At(view), _) => *view,
            (Looks::Top, Some(axis)) => {
                let upward = axis.direction.z < 0.0;
                View::Along { direction: if upward { -axis.direction } else { axis.direction } }
            }
            (Looks::Top, None) => View::Top,
        })
        .collect();
    let circle = match (args.circle, bodies.first(), &axis) {
        (Some(diameter), Some(body), Some(axis)) => {
            let line = circle::target(body, axis, diameter).map_err(Stop::Failed)?;
            Some((line, format!("target {diameter} mm")))
        }
        (Some(_), ..) => {
            let what = "--circle wants a body with a rim, about whose axis it lies; leave it out for a closed surface";
            return Err(Stop::Usage(what.to_owned()));
        }
        (None, ..) => None,
    };
    let is_alone = views.len() == 1 && (moments.len() == 1 || args.film.is_some() || args.frames.is_some());
    let look = Look {
        side: args.size.unwrap_or(if is_alone { 720 } else { 420 }),
        with_lines: !args.no_mesh_lines,
        with_fibres: !args.no_fibres,
        with_tips: args.tips,
        is_bare: args.bare,
        turned_opacity: args.flap_opacity,
        circle,
    };
    Sheet::new(look, &views, &bodies).map_err(|what| Stop::Failed(format!("{}: {what}", args.source)))
}

/// A time as a caption.
fn caption(time: f64) -> String {
    if time < 10_000.0 { format!("{} ms", (time * 10.0).round() / 10.0) } else { format!("{:.2} s", time * 1e-3) }
}

fn still(sheet: &Sheet, moments: &[Moment], title: &str, out: &Path) -> Result<(), Stop> {
    let drawn: Vec<Drawn> = moments.iter().map(|moment| moment.drawn(caption(moment.time))).collect();
    let note = match moments {
        [one] => format!("after {}", caption(one.time)),
        [first, .., last] => format!("from {} to {}", caption(first.time), caption(last.time)),
        [] => String::new(),
    };
    let pixels = sheet.draw(&drawn, moments.len() > 1, title, &note).map_err(Stop::Failed)?;
    write(&pixels, out)?;
    say(&format!("written to {}", out.display()))
}

/// The most pixels of a film, all frames together.
const MOST_PIXELS: u64 = 350_000_000;

/// One picture of a film.
fn picture(sheet: &Sheet, moment: &Moment, title: &str) -> Result<Pixmap, Stop> {
    let note = format!("t = {:.2} s", moment.time * 1e-3);
    sheet.draw(&[moment.drawn(String::new())], false, title, &note).map_err(Stop::Failed)
}

fn film(args: &RenderArgs, sheet: &Sheet, moments: &[Moment], title: &str, out: &Path) -> Result<(), Stop> {
    let mut pictures = Vec::with_capacity(moments.len());
    for moment in moments {
        let pixels = picture(sheet, moment, title)?;
        if u64::from(pixels.width()) * u64::from(pixels.height()) * moments.len() as u64 > MOST_PIXELS {
            let what =
                "such a film takes more than 1 GB of memory; choose a smaller --size or fewer moments, or --frames";
            return Err(Stop::Failed(format!("{}: {what}", out.display())));
        }
        // Drawn on white, so that every pixel is opaque.
        let colours = pixels.pixels().iter().map(|p| [p.red(), p.green(), p.blue()]).collect();
        pictures.push(Picture { width: pixels.width(), height: pixels.height(), pixels: colours });
    }
    let bytes = film::encode(&pictures, args.fps).map_err(|what| Stop::Failed(format!("{}: {what}", out.display())))?;
    file::replace(out, &bytes)?;
    let size = bytes.len() as f64 / 1e6;
    say(&format!("{} moments, {size:.2} MB, written to {}", moments.len(), out.display()))
}

fn numbered(args: &RenderArgs, sheet: &Sheet, moments: &[Moment], title: &str, out: &Path) -> Result<(), Stop> {
    remove_earlier(out)?;
    for (number, moment) in moments.iter().enumerate() {
        write(&picture(sheet, moment, title)?, &out.join(format!("frame-{number:04}.png")))?;
    }
    let folder = out.display();
    say(&format!("{} pictures written to {folder}; a film of them:", moments.len()))?;
    let quality = "-c:v libx264 -pix_fmt yuv420p -crf 18";
    say(&format!("ffmpeg -framerate {} -i {folder}/frame-%04d.png {quality} {folder}/film.mp4", args.fps))
}

/// Takes away numbered pictures of an earlier film, which would be the end of this one.
fn remove_earlier(folder: &Path) -> Result<(), Stop> {
    let failed = |error: std::io::Error| Stop::Failed(format!("cannot write {}: {error}", folder.display()));
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let digits = name.strip_prefix("frame-").and_then(|name| name.strip_suffix(".png"));
        if digits.is_some_and(|digits| digits.len() >= 4 && digits.bytes().all(|byte| byte.is_ascii_digit())) {
            std::fs::remove_file(entry.path()).map_err(failed)?;
        }
    }
    Ok(())
}

fn write(pixels: &Pixmap, out: &Path) -> Result<(), Stop> {
    let bytes = pixels.encode_png().map_err(|error| Stop::Failed(format!("{}: {error}", out.display())))?;
    Ok(file::replace(out, &bytes)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_become_one_with_their_own_corners() {
        let one =
            BodyFrame { positions: vec![glam::DVec3::ZERO; 3], triangles: vec![[0, 1, 2]], ..BodyFrame::default() };
        assert_eq!(together(vec![one.clone(), one]).triangles, [[0, 1, 2], [3, 4, 5]]);
    }
}
