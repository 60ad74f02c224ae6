//! The program `ra_pfm`: see luxpipe's src/filters/ra_pfm.rs.

fn main() -> std::process::ExitCode {
    luxpipe::cli::main::<luxpipe::filters::RaPfm>()
}
