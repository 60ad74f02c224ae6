//! The program `pdisplay`: see luxpipe's src/filters/pdisplay.rs.

fn main() -> std::process::ExitCode {
    luxpipe::cli::main::<luxpipe::filters::Pdisplay>()
}
