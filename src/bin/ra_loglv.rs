//! The program `ra_loglv`: see luxpipe's src/filters/ra_loglv.rs.

fn main() -> std::process::ExitCode {
    luxpipe::cli::main::<luxpipe::filters::RaLoglv>()
}
