//! The program `specmat`: see luxpipe's src/filters/specmat.rs.

fn main() -> std::process::ExitCode {
    luxpipe::cli::main::<luxpipe::filters::Specmat>()
}
