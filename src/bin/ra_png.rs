//! The program `ra_png`: see luxpipe's src/filters/ra_png.rs.

fn main() -> std::process::ExitCode {
    luxpipe::cli::main::<luxpipe::filters::RaPng>()
}
