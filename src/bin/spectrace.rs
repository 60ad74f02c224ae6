//! The program `spectrace`: see luxpipe's src/filters/spectrace.rs.

fn main() -> std::process::ExitCode {
    luxpipe::cli::main::<luxpipe::filters::Spectrace>()
}
