//! The bits of every scene of the catalog and of this folder: the same for any number of threads, with and without wide
//! instructions, and after going back to a snapshot. They are the same as when `hashes.txt` was written, in debug and in release builds.
//!
//! A build without the feature `direct` has the same bits on every machine: the column `any`. With it they depend on the machine in
//! one thing, the instructions that the sparse factor's library picks. Each architecture with its instructions has a column; one
//! that the file does not know is reported and not judged. AVX-512 makes no difference: emulated without it
//! (`qemu-x86_64 -cpu Haswell-v4`), a machine that has it gives the bits of every scene that it gives with it.

use rhexis::components::TearLog;
use rhexis::snapshot::StateHash;
use rhexis_scene::catalog::CATALOG;
use rhexis_scene::schema::Mode;
use rhexis_scene::{Document, Instance};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::PathBuf;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

/// With this in the environment, the file is written anew.
const UPDATE: &str = "RHEXIS_UPDATE_GOLDEN";

const HOW: &str = "If the change of the numbers is meant, write the file anew by both builds and say in the commit why they change:
    RHEXIS_UPDATE_GOLDEN=1 cargo test --release --test golden
    RHEXIS_UPDATE_GOLDEN=1 cargo test --release --test golden -p rhexis-scene
(columns of other machines are left out: they are told there and not judged). If it is not meant, it is a bug: bisect it.";

/// The column of builds without a sparse factor.
const ANY: &str = "any";

/// The architecture and the instructions that count.
fn target() -> String {
    #[cfg(target_arch = "x86_64")]
    let level = if std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma") {
        "-avx2"
    } else {
        "-sse2"
    };
    #[cfg(not(target_arch = "x86_64"))]
    let level = "";
    format!("{}{level}", std::env::consts::ARCH)
}

/// A scene, and the number of steps after which tears have advanced in it where they are to.
struct Window {
    name: &'static str,
    text: &'static str,
    torn: Option<usize>,
}

/// Scenes of the catalog with the steps after which tears have advanced in them: their windows end there.
const TORN: [(&str, usize); 8] = [
    ("capsulorhexis", 240),
    ("capsulorhexis-runout", 240),
    ("capsulorhexis-rescue", 240),
    ("fig2-tear", 100),
    ("fig2-tear-iso", 100),
    ("fig2-tear-stable", 40),
    ("two-points", 120),
    ("many", 60),
];

/// Scenes of this folder, which tear too.
const OWN: [Window; 3] = [
    Window { name: "trouser", text: include_str!("trouser.toml"), torn: Some(60) },
    Window { name: "flap", text: include_str!("flap.toml"), torn: Some(70) },
    Window { name: "rough-hand", text: include_str!("rough-hand.toml"), torn: Some(90) },
];

/// All of them, the lead scenes, which take longest, first.
fn windows() -> Vec<Window> {
    let torn = |name: &str| TORN.iter().find(|(torn, _)| *torn == name).map(|(_, steps)| *steps);
    let catalog = CATALOG.iter().map(|entry| Window { name: entry.name, text: entry.text, torn: torn(entry.name) });
    catalog.chain(OWN).collect()
}

/// Scenes that are run side by side.
const SIDE_BY_SIDE: usize = 2;

impl Window {
    fn instance(&self, threads: usize, is_portable: bool) -> Instance {
        let mut document = Document::new(self.text, self.name);
        document.set(&format!("run.threads={threads}")).unwrap();
        document.set(&format!("run.portable_instructions={is_portable}")).unwrap();
        document.scene().unwrap().instantiate().unwrap()
    }

    /// Steps of the window; static steps are long ones.
    fn steps(&self, instance: &Instance) -> usize {
        let wanted = self.torn.unwrap_or(match (instance.run.mode, instance.bodies.len()) {
            (Mode::Static, _) => 1,
            // Many bodies, or large ones.
            (Mode::Dynamic, 2..) => 4,
            (Mode::Dynamic, _) => 30,
        });
        wanted.min(instance.run.steps as usize)
    }

    /// Number of steps and the hash after them, the same for all ways there.
    fn run(&self) -> Result<(usize, StateHash), String> {
        let name = self.name;
        let mut first = self.instance(1, false);
        let steps = self.steps(&first);
        let half = steps / 2;
        go(&mut first, half);
        let snapshot = first.simulation.snapshot();
        let hash = go(&mut first, steps - half);
        let area: f64 = first.simulation.world().query::<&TearLog>().iter().map(|log| log.area).sum();
        if self.torn.is_some() && !(area > 0.0) {
            return Err(format!("{name}: nothing has torn in {steps} steps, so that its bits tell nothing of tears"));
        }
        first.simulation.restore(&snapshot).unwrap();
        let again = go(&mut first, steps - half);
        if again != hash {
            return Err(format!("{name}: {again} after going back to step {half}, {hash} before"));
        }
        for (threads, is_portable) in [(2, false), (3, true), (8, false)] {
            let other = go(&mut self.instance(threads, is_portable), steps);
            if other != hash {
                let how = format!("{threads} threads, portable instructions: {is_portable}");
                return Err(format!("{name}: {other} with {how}; {hash} with one thread"));
            }
        }
        Ok((steps, hash))
    }
}

fn go(instance: &mut Instance, steps: usize) -> StateHash {
    (0..steps).for_each(|_| _ = instance.advance().unwrap());
    instance.simulation.hash()
}

/// Runs all windows, [`SIDE_BY_SIDE`] at a time; the results are in their order.
fn run_all(windows: &[Window]) -> Vec<Result<(usize, StateHash), String>> {
    let results: Vec<OnceLock<_>> = windows.iter().map(|_| OnceLock::new()).collect();
    let next = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..SIDE_BY_SIDE {
            scope.spawn(|| {
                while let Some((window, result)) = {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    windows.get(i).zip(results.get(i))
                } {
                    result.get_or_init(|| window.run());
                }
            });
        }
    });
    results.into_iter().filter_map(OnceLock::into_inner).collect()
}

#[test]
fn any_number_of_threads_any_instructions_and_a_way_back_give_the_golden_bits() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden/hashes.txt");
    let target = target();
    let (own, other) = if cfg!(feature = "direct") { (&*target, ANY) } else { (ANY, &*target) };
    let windows = windows();
    let mut found = BTreeMap::new();
    let mut faults = String::new();
    for (window, result) in windows.iter().zip(run_all(&windows)) {
        match result {
            Ok(result) => _ = found.insert(window.name, result),
            Err(fault) => _ = writeln!(faults, "{fault}"),
        }
    }
    assert!(faults.is_empty(), "{faults}");
    let text = std::fs::read_to_string(&path).unwrap();
    let column = |name: &str| -> BTreeMap<String, String> {
        let lines = text.lines().filter_map(|line| line.strip_prefix(name)?.strip_prefix(' ')?.split_once(' '));
        lines.map(|(scene, rest)| (scene.to_owned(), rest.to_owned())).collect()
    };
    if std::env::var_os(UPDATE).is_some() {
        let mut text =
            format!("# column scene steps hash. See main.rs beside this file.\n# {}\n", HOW.replace('\n', "\n# "));
        let now = found.iter().map(|(name, (steps, hash))| (name.to_string(), format!("{steps} {hash}"))).collect();
        for (column, hashes) in [(own, now), (other, column(other))] {
            hashes.iter().for_each(|(name, rest)| _ = writeln!(text, "{column} {name} {rest}"));
        }
        std::fs::write(&path, text).unwrap();
        return;
    }
    let golden = column(own);
    if golden.is_empty() {
        println!("no golden hashes for {own}: the bits of this machine are not judged");
        return;
    }
    for (name, (steps, hash)) in &found {
        let now = format!("{steps} {hash}");
        let then = golden.get(*name).map_or("nothing", String::as_str);
        if now != then {
            let _ = writeln!(faults, "{name}: now {now}, golden {then}");
        }
    }
    assert!(
        faults.is_empty(),
        "the bits after so many steps are not those of tests/golden/hashes.txt, column {own}:\n{faults}{HOW}"
    );
}
