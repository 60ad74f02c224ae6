//! The program `ra_pixlog`: see luxpipe's src/filters/ra_pixlog.rs.

fn main() -> std::process::ExitCode {
    luxpipe::cli::main::<luxpipe::filters::RaPixlog>()
}
