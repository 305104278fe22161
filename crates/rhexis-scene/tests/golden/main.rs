//! The bits of every scene of the catalog: the same for any number of threads, with and without wide instructions, and after going
//! back to a snapshot. They are the same as when `hashes.txt` was written, in debug and in release builds.
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

fn instance(name: &str, threads: usize, is_portable: bool) -> Instance {
    let mut document = Document::named(name).unwrap();
    document.set(&format!("run.threads={threads}")).unwrap();
    document.set(&format!("run.portable_instructions={is_portable}")).unwrap();
    document.scene().unwrap().instantiate().unwrap()
}

/// Scenes with the steps after which tears have advanced in them: their windows end there.
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

/// Steps of a scene's window; static steps are long ones.
fn steps(torn: Option<usize>, instance: &Instance) -> usize {
    let wanted = torn.unwrap_or(match (instance.run.mode, instance.bodies.len()) {
        (Mode::Static, _) => 1,
        // Many bodies, or large ones.
        (Mode::Dynamic, 2..) => 4,
        (Mode::Dynamic, _) => 30,
    });
    wanted.min(instance.run.steps as usize)
}

fn go(instance: &mut Instance, steps: usize) -> StateHash {
    (0..steps).for_each(|_| _ = instance.advance().unwrap());
    instance.simulation.hash()
}

#[test]
fn any_number_of_threads_any_instructions_and_a_way_back_give_the_golden_bits() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden/hashes.txt");
    let target = target();
    let (own, other) = if cfg!(feature = "direct") { (&*target, ANY) } else { (ANY, &*target) };
    let mut found = BTreeMap::new();
    for entry in CATALOG {
        let mut first = instance(entry.name, 1, false);
        let torn = TORN.iter().find(|(name, _)| *name == entry.name).map(|(_, steps)| *steps);
        let steps = steps(torn, &first);
        let half = steps / 2;
        go(&mut first, half);
        let snapshot = first.simulation.snapshot();
        let hash = go(&mut first, steps - half);
        if torn.is_some() {
            let area: f64 = first.simulation.world().query::<&TearLog>().iter().map(|log| log.area).sum();
            assert!(
                area > 0.0,
                "{}: nothing has torn in {steps} steps, so that its bits tell nothing of tears",
                entry.name
            );
        }
        first.simulation.restore(&snapshot).unwrap();
        assert_eq!(go(&mut first, steps - half), hash, "{}: after going back to step {half}", entry.name);
        for (threads, is_portable) in [(2, false), (3, true), (8, false)] {
            let other = go(&mut instance(entry.name, threads, is_portable), steps);
            assert_eq!(other, hash, "{}: {threads} threads, portable instructions: {is_portable}", entry.name);
        }
        found.insert(entry.name, (steps, hash));
    }
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
    let mut faults = String::new();
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
