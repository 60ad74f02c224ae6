//! The program `picinfo`: see luxpipe's src/filters/picinfo.rs.

fn main() -> std::process::ExitCode {
    luxpipe::cli::main::<luxpipe::filters::Picinfo>()
}
