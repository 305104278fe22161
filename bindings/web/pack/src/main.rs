//! Writes the JavaScript and the types beside a WebAssembly module that cargo has built: `rhexis-web-pack MODULE.wasm FOLDER`.
//!
//! What the tool `wasm-bindgen` does, of the version that the module was built with; nothing has to be installed.

use std::env::args_os;
use std::process::ExitCode;
use wasm_bindgen_cli_support::Bindgen;

fn main() -> ExitCode {
    let mut words = args_os().skip(1);
    let (Some(module), Some(folder), None) = (words.next(), words.next(), words.next()) else {
        eprintln!("usage: rhexis-web-pack MODULE.wasm FOLDER");
        return ExitCode::from(2);
    };
    let mut bindgen = Bindgen::new();
    let made = bindgen.web(true).and_then(|bindgen| {
        bindgen
            .input_path(&module)
            .typescript(true)
            .remove_name_section(true)
            .remove_producers_section(true)
            .out_name("rhexis_web")
            .generate(&folder)
    });
    match made {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}: {error:#}", module.display());
            ExitCode::FAILURE
        }
    }
}
