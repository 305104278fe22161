//! Repeats a recording and prints the hash of its end: `replay_recording FILE`, as `rhexis replay` does, without the program.

use rhexis::replay::Recording;
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("usage: replay_recording FILE")?;
    let simulation = Recording::load(path)?.replay()?;
    println!("{}", simulation.hash());
    Ok(())
}
