//! The program `ra_exr`: see luxpipe's src/filters/ra_exr.rs.

fn main() -> std::process::ExitCode {
    luxpipe::cli::main::<luxpipe::filters::RaExr>()
}
