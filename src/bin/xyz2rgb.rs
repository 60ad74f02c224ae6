//! The program `xyz2rgb`: see luxpipe's src/filters/xyz2rgb.rs.

fn main() -> std::process::ExitCode {
    luxpipe::cli::main::<luxpipe::filters::Xyz2rgb>()
}
