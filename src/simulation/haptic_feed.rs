//! How a haptic thread reads the model that the simulation publishes: without locks, so that neither waits for the other.

use glam::{DMat3, DVec3};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering, fence};

/// Numbers of a model.
const MODEL_NUMBERS: usize = 16;

/// The force of a tool on the tissue around its present position, to first order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HapticModel {
    /// When it was made \[ms\].
    pub time: f64,
    /// The tool's position then \[mm\].
    pub position: DVec3,
    /// Force of the tool on the tissue then \[N\]; the hand feels the opposite.
    pub force: DVec3,
    /// By how much the force grows along a motion of the tool \[N/mm\]: symmetric and positive semidefinite, never stiffer than the
    /// tool's own springs.
    pub stiffness: DMat3,
}

impl HapticModel {
    /// Force of the tool on the tissue \[N\] with the tool at a position \[mm\].
    pub fn force_at(&self, position: DVec3) -> DVec3 {
        self.force + self.stiffness * (position - self.position)
    }

    fn numbers(&self) -> [f64; MODEL_NUMBERS] {
        let mut numbers = [0.0; MODEL_NUMBERS];
        numbers[0] = self.time;
        numbers[1..4].copy_from_slice(&self.position.to_array());
        numbers[4..7].copy_from_slice(&self.force.to_array());
        numbers[7..].copy_from_slice(&self.stiffness.to_cols_array());
        numbers
    }

    fn from_numbers(n: &[f64; MODEL_NUMBERS]) -> Self {
        let vector = |first: usize| DVec3::new(n[first], n[first + 1], n[first + 2]);
        let stiffness = DMat3::from_cols(vector(7), vector(10), vector(13));
        Self { time: n[0], position: vector(1), force: vector(4), stiffness }
    }
}

/// A sequence lock of atomics (Boehm 2012, Can seqlocks get along with programming language memory models?): its count is odd
/// while the numbers are written, and a reader that has seen it change reads again.
#[derive(Debug, Default)]
struct Shared {
    count: AtomicU64,
    numbers: [AtomicU64; MODEL_NUMBERS],
}

/// The simulation's end: publishes models.
#[derive(Debug)]
pub struct HapticSender(Arc<Shared>);

/// The haptic thread's end: reads the last model. There may be several.
#[derive(Clone, Debug)]
pub struct HapticReceiver(Arc<Shared>);

/// A feed of haptic models from the thread that steps to threads that do not wait.
pub fn haptic_feed() -> (HapticSender, HapticReceiver) {
    let shared = Arc::new(Shared::default());
    (HapticSender(Arc::clone(&shared)), HapticReceiver(shared))
}

impl HapticSender {
    /// Publishes a model in place of the last one. Never waits, never allocates.
    pub fn send(&mut self, model: &HapticModel) {
        let Shared { count, numbers } = &*self.0;
        let before = count.load(Ordering::Relaxed);
        count.store(before + 1, Ordering::Relaxed);
        fence(Ordering::Release);
        for (shared, number) in numbers.iter().zip(model.numbers()) {
            shared.store(number.to_bits(), Ordering::Relaxed);
        }
        count.store(before + 2, Ordering::Release);
    }
}

impl HapticReceiver {
    /// The last model; `None` before the first. Reads again while one is being published, which takes some nanoseconds.
    pub fn latest(&self) -> Option<HapticModel> {
        let Shared { count, numbers } = &*self.0;
        loop {
            let before = count.load(Ordering::Acquire);
            if before == 0 {
                return None;
            }
            let read = std::array::from_fn(|i| f64::from_bits(numbers[i].load(Ordering::Relaxed)));
            fence(Ordering::Acquire);
            if before % 2 == 0 && count.load(Ordering::Relaxed) == before {
                return Some(HapticModel::from_numbers(&read));
            }
            std::hint::spin_loop();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_reader_sees_halves_of_two_models() {
        let model = |i: u32| {
            let x = f64::from(i);
            let vector = DVec3::splat(x);
            HapticModel {
                time: x,
                position: vector,
                force: vector,
                stiffness: DMat3::from_cols(vector, vector, vector),
            }
        };
        let (mut sender, receiver) = haptic_feed();
        assert_eq!(receiver.latest(), None);
        std::thread::scope(|scope| {
            let readers: Vec<_> = (0..2)
                .map(|_| {
                    let receiver = receiver.clone();
                    scope.spawn(move || {
                        let mut last = 0.0;
                        while last < 20_000.0 {
                            if let Some(read) = receiver.latest() {
                                assert_eq!(read, model(read.time as u32));
                                assert!(read.time >= last, "models do not go back");
                                last = read.time;
                            }
                        }
                    })
                })
                .collect();
            (1..=20_000).for_each(|i| sender.send(&model(i)));
            readers.into_iter().for_each(|reader| reader.join().unwrap());
        });
    }
}
