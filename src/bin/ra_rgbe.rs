//! The program `ra_rgbe`: see luxpipe's src/filters/ra_rgbe.rs.

fn main() -> std::process::ExitCode {
    luxpipe::cli::main::<luxpipe::filters::RaRgbe>()
}
