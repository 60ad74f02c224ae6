//! Writes man pages and shell completions of all programs from their command lines: `make man`. Arguments: the folder, and what stands in
//! front of every program's name.

use std::fs::{self, File};
use std::path::PathBuf;

use clap_complete::{Shell, generate};
use clap_mangen::Man;

fn main() -> std::io::Result<()> {
    let out = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "out/man".into()));
    let prefix = std::env::args().nth(2).unwrap_or_default();
    let commands = luxpipe::filters::ALL
        .iter()
        .map(|f| f.command())
        .chain([luxpipe::pipeline::command(), luxpipe::tradeoff::command()])
        .collect::<Vec<_>>();
    for folder in ["man1", "bash", "zsh", "fish"] {
        fs::create_dir_all(out.join(folder))?;
    }
    for mut command in commands {
        // For as long as the program runs, which is not long.
        let name: &'static str = format!("{prefix}{}", command.get_name()).leak();
        command = command.name(name);
        Man::new(command.clone()).render(&mut File::create(out.join("man1").join(format!("{name}.1")))?)?;
        for (shell, folder, file) in [
            (Shell::Bash, "bash", name.to_string()),
            (Shell::Zsh, "zsh", format!("_{name}")),
            (Shell::Fish, "fish", format!("{name}.fish")),
        ] {
            generate(shell, &mut command, name, &mut File::create(out.join(folder).join(file))?);
        }
    }
    Ok(())
}
