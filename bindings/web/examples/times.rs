//! Times of native steps on one core, to compare the browser's with: `times PLAN.json` prints a line of JSON for every entry, with the
//! median processor time of a step.

#[path = "../tests/plan/mod.rs"]
mod plan;

use cpu_time::ThreadTime;
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("usage: times PLAN.json")?;
    for entry in plan::read(&std::fs::read_to_string(path)?)? {
        let mut times = Vec::new();
        entry.run(|engine| {
            let begin = ThreadTime::now();
            let done = engine.step();
            times.push(begin.elapsed().as_secs_f64() * 1e3);
            done
        })?;
        times.sort_by(f64::total_cmp);
        let step_ms = times.get(times.len() / 2).copied().unwrap_or_default();
        println!("{}", serde_json::json!({ "scene": entry.scene, "steps": entry.steps, "step_ms": step_ms }));
    }
    Ok(())
}
