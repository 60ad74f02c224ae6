//! Writes man pages and shell completions of all programs from their command lines: `make man`.

use std::fs::{self, File};
use std::path::PathBuf;

use clap_complete::{Shell, generate};
use clap_mangen::Man;

fn main() -> std::io::Result<()> {
    let out = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "out/man".into()));
    let commands = luxpipe::filters::ALL
        .iter()
        .map(|f| f.command())
        .chain([luxpipe::pipeline::command(), luxpipe::tradeoff::command()])
        .collect::<Vec<_>>();
    for folder in ["man1", "bash", "zsh", "fish"] {
        fs::create_dir_all(out.join(folder))?;
    }
    for mut command in commands {
        let name = command.get_name().to_string();
        Man::new(command.clone()).render(&mut File::create(out.join("man1").join(format!("{name}.1")))?)?;
        for (shell, folder, file) in [
            (Shell::Bash, "bash", name.clone()),
            (Shell::Zsh, "zsh", format!("_{name}")),
            (Shell::Fish, "fish", format!("{name}.fish")),
        ] {
            generate(shell, &mut command, &name, &mut File::create(out.join(folder).join(file))?);
        }
    }
    Ok(())
}
