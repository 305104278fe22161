//! The `rhexis` program; everything it does is in [`rhexis::cli`].

fn main() -> std::process::ExitCode {
    rhexis::cli::main()
}
