//! The program `rad2scene`: see luxpipe's src/filters/rad2scene.rs.

fn main() -> std::process::ExitCode {
    luxpipe::cli::main::<luxpipe::filters::Rad2scene>()
}
