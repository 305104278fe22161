//! Ctrl-C and SIGTERM: the first asks the program to end with what it has, the second ends it at once.

use super::Stop;
use signal_hook::consts::signal::{SIGINT, SIGTERM};
use signal_hook::flag::{register, register_conditional_shutdown};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The exit code of an interrupted program: 128 and the number of SIGINT, as shells report it.
pub(super) const EXIT_CODE: u8 = 130;

/// Whether somebody has asked the program to end.
#[derive(Clone)]
pub(super) struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Takes the signals from here on.
    ///
    /// # Errors
    /// Where the system refuses.
    pub(crate) fn watch() -> Result<Self, Stop> {
        let asked = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            // In this order, or the first would find the flag already set.
            register_conditional_shutdown(signal, EXIT_CODE.into(), asked.clone())
                .and_then(|_| register(signal, asked.clone()))
                .map_err(|error| Stop::Failed(format!("cannot take signals: {error}")))?;
        }
        Ok(Self(asked))
    }

    /// Asks it to end, as Ctrl-C does.
    pub(crate) fn ask(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    pub(crate) fn is_asked(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// A file that grows beyond the limit of the user (`ulimit -f`) is an error of that file, as a full disk is, and not the end of the
/// program.
pub(super) fn outlive_file_limits() {
    // Where it cannot be had, the program ends there as any other does.
    #[cfg(unix)]
    let _ = register(signal_hook::consts::signal::SIGXFSZ, Arc::default());
}
