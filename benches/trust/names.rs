//! Names of files that a shell would run, split or expand, and text that a terminal would obey: as arguments, in scenes and pipelines, in
//! headers. A marker file tells whether any of it was run.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::escapes;
use crate::run::{Demands, Ended, filter, machine, path, program, row, run, shell};
use crate::subjects::{self, Subject, toml_text};

/// Stems of names.
pub const ODD: [&str; 20] = [
    "a b",
    "$(touch MARK)",
    "`touch MARK`",
    ";touch MARK;",
    "|touch MARK|",
    "&touch MARK&",
    "'q",
    "\"q\"",
    "'\"",
    "new\nline",
    "tab\tcr\r",
    "%n%s%x",
    "*?[a]",
    "~",
    "back\\slash",
    "#x=y",
    "\u{1b}[31m",
    "$HOME",
    "a\nCOMPONENTS=Y",
    "<b>&amp;\"'",
];

/// Runs all of it and prints a table.
pub fn section(demands: &mut Demands) -> std::io::Result<()> {
    println!("## Names and text from outside\n\n{}\n\n| what | tried | broken |\n|---|---|---|", machine());
    let folder = tempfile::tempdir()?;
    subjects::prepare(folder.path(), 24)?;
    row("odd names as input and output, every program", demands, |d| odd_names(folder.path(), d))?;
    row("names that begin with a dash", demands, |d| dashes(folder.path(), d))?;
    row("odd names in pipelines: run, --shell into sh, --make into make, --dry-run", demands, |d| {
        pipelines(folder.path(), d)
    })?;
    row("names of inputs that would be commands of what luxpipe prints", demands, |d| printed(folder.path(), d))?;
    row("odd names of meshes, spectra and pictures in scenes", demands, |d| scenes(folder.path(), d))?;
    row("text as a stage's program, argument or variable", demands, |d| exec(folder.path(), d))?;
    row("files that never end, named by scenes", demands, |d| endless(folder.path(), d))?;
    row("files opened beside those that a scene or pipeline names", demands, |d| opened(folder.path(), d))?;
    row("escapes in headers, through every program", demands, |d| escapes::headers(folder.path(), d))?;
    row("escapes in other codings' texts", demands, |d| escapes::codings(folder.path(), d))?;
    row("escapes in scenes, tables, pipelines and arguments", demands, |d| escapes::texts(folder.path(), d))?;
    row("markup in pages and charts", demands, |d| escapes::markup(folder.path(), d))
}

/// Was a command run, or does a line for the eye hold what a terminal obeys?
fn harmless(what: &str, command: &str, ended: &Ended, folder: &Path, demands: &mut Demands) {
    if folder.join("MARK").exists() {
        demands.broken(&format!("{what}: a command was run"), command);
        let _ = fs::remove_file(folder.join("MARK"));
    }
    if let Some(c) = escapes::obeyed(&ended.stderr) {
        demands.broken(&format!("{what}: standard error has {c:?}"), command);
    }
}

/// The header's lines of a float stream.
fn header_lines(bytes: &[u8]) -> Option<usize> {
    let end = bytes.windows(2).position(|w| w == b"\n\n").filter(|_| bytes.starts_with(b"#?"))?;
    Some(bytes[..end].iter().filter(|b| **b == b'\n').count())
}

fn words(s: &Subject, input: &str, out: &str) -> Vec<String> {
    s.words.iter().map(|w| w.replace("{in}", input).replace("{out}", out)).collect()
}

fn odd_names(folder: &Path, demands: &mut Demands) -> std::io::Result<usize> {
    let mut tried = 0;
    for s in &subjects::all().into_iter().map(Subject::small).filter(|s| !s.pipeline && s.streams).collect::<Vec<_>>() {
        let suffix = Path::new(s.input).extension().unwrap_or_default().to_string_lossy().into_owned();
        let plain = run(&mut filter(s.program, &words(s, s.input, "plain.out"), folder), b"")?;
        let plain = fs::read(folder.join("plain.out"))
            .map_err(|e| std::io::Error::other(format!("{}: {e} {}", s.program, plain.stderr)))?;
        for odd in ODD {
            let (input, out) = (format!("{odd}.{suffix}"), format!("{odd}.out"));
            fs::copy(folder.join(s.input), folder.join(&input))?;
            let words = words(s, &input, &out);
            let ended = run(&mut filter(s.program, &words, folder), b"")?;
            let command = format!("{} {words:?}", s.program);
            harmless(&format!("{} with {odd:?}", s.program), &command, &ended, folder, demands);
            let made = fs::read(folder.join(&out)).unwrap_or_default();
            if ended.status != 0 || made.is_empty() {
                demands.broken(
                    &format!("{} with {odd:?}: status {}: {}", s.program, ended.status, ended.stderr.trim()),
                    &command,
                );
            } else if header_lines(&made) != header_lines(&plain) {
                demands.broken(&format!("{} with {odd:?}: the name makes lines of the header", s.program), &command);
            }
            tried += 1;
            let _ = (fs::remove_file(folder.join(&input)), fs::remove_file(folder.join(&out)));
        }
    }
    Ok(tried)
}

fn dashes(folder: &Path, demands: &mut Demands) -> std::io::Result<usize> {
    let mut tried = 0;
    for s in &subjects::all().into_iter().map(Subject::small).filter(|s| !s.pipeline && s.streams).collect::<Vec<_>>() {
        let input = format!("-{}", s.input);
        fs::copy(folder.join(s.input), folder.join(&input))?;
        let with_path = words(s, &format!("./{input}"), "./-o");
        // Options that take the output come before the two dashes.
        let place = s.words.iter().position(|w| w == "{in}").unwrap_or(0);
        let option =
            s.words.get(place.wrapping_sub(1)).is_some_and(|w| w.starts_with('-')) || s.words.iter().any(|w| w == "-o");
        let mut after = words(s, &input, "-o");
        let first = if s.program == "relight" || s.program == "pcompare" { 0 } else { place };
        after.insert(first, "--".into());
        for words in [Some(with_path), (!option).then_some(after)].into_iter().flatten() {
            let ended = run(&mut filter(s.program, &words, folder), b"")?;
            if ended.status != 0 || fs::read(folder.join("-o")).unwrap_or_default().is_empty() {
                demands.broken(
                    &format!("{} with a dash: status {}: {}", s.program, ended.status, ended.stderr.trim()),
                    &format!("{words:?}"),
                );
            }
            let _ = fs::remove_file(folder.join("-o"));
            tried += 1;
        }
    }
    Ok(tried)
}

fn pipelines(folder: &Path, demands: &mut Demands) -> std::io::Result<usize> {
    let (mut tried, saved) = (0, |odd: &str| format!("{odd}-saved.hdr"));
    for odd in ODD {
        let (input, out) = (format!("{odd}.lux"), format!("{odd}.png"));
        fs::copy(folder.join("xyz.lux"), folder.join(&input))?;
        let text = subjects::pipeline(&input, &out)
            .replace("to = \"D50\"", &format!("to = \"D50\"\nsave = {}", toml_text(&saved(odd))));
        fs::write(folder.join("odd.toml"), text)?;
        let clean = || [&out, &saved(odd)].iter().for_each(|n| drop(fs::remove_file(folder.join(n))));
        let whole = || [&out, &saved(odd)].iter().all(|n| fs::metadata(folder.join(n)).is_ok_and(|m| m.len() > 0));
        for (script, makes) in [
            ("luxpipe --quiet odd.toml", true),
            ("luxpipe --quiet --shell odd.toml > line && sh line 2> /dev/null", true),
            ("luxpipe --make odd.toml > odd.mk && make -s -f odd.mk", true),
            ("luxpipe --snakemake odd.toml > Snakefile", false),
            ("luxpipe --dry-run odd.toml >&2", false),
        ] {
            let ended = shell(script, folder)?;
            harmless(&format!("luxpipe with {odd:?}, {script}"), script, &ended, folder, demands);
            // Some names have no spelling in a Makefile: those are refused in a line.
            let refused = ended.status == 1 && ended.stderr.starts_with("luxpipe: ") && script.contains("make");
            if makes && !refused && (ended.status != 0 || !whole()) {
                demands.broken(
                    &format!("luxpipe with {odd:?}, {script}: status {}: {}", ended.status, ended.stderr.trim()),
                    script,
                );
            }
            clean();
            tried += 1;
        }
        fs::remove_file(folder.join(&input))?;
    }
    Ok(tried)
}

/// Names of inputs that end a list of files where a printed file is read as a program; the file before them is there.
fn printed(folder: &Path, demands: &mut Demands) -> std::io::Result<usize> {
    let tail = [
        "\n\ttouch\tMARK",
        ";touch$${IFS}MARK",
        ";touch\tMARK;",
        "\nresult:\n\ttouch\tMARK\n",
        "|touch\tMARK",
        "$(shell touch MARK)",
        "`touch\tMARK`",
        "\"\ntouch\tMARK\n\"",
        "'\"; touch MARK; '",
    ];
    fs::copy(folder.join("xyz.lux"), folder.join("x.lux"))?;
    for tail in tail {
        let name = format!("x.lux{}", tail.replace("$$", "$"));
        fs::copy(folder.join("xyz.lux"), folder.join(&name))?;
        fs::write(folder.join("print.toml"), subjects::pipeline(&format!("x.lux{tail}"), "result"))?;
        for script in [
            "luxpipe --make print.toml > print.mk && make -s -f print.mk",
            "luxpipe --shell print.toml > line && sh line",
            "luxpipe --make --parts 2 print.toml > print.mk && make -s -f print.mk",
        ] {
            let ended = shell(script, folder)?;
            harmless(
                &format!("an input {name:?}, {script}"),
                script,
                &Ended { stderr: String::new(), ..ended },
                folder,
                demands,
            );
        }
        fs::remove_file(folder.join(&name))?;
    }
    Ok(3 * tail.len())
}

fn scenes(folder: &Path, demands: &mut Demands) -> std::io::Result<usize> {
    let root = crate::run::root();
    let mut tried = 0;
    for (what, file) in [
        ("mesh", "scenes/tower/mug.obj"),
        ("spectrum", "spectra/cornell_white.csv"),
        ("texture", "tests/data/png/grey1.png"),
    ] {
        let suffix = file.rsplit('.').next().unwrap_or_default();
        for odd in ODD {
            let name = format!("{odd}.{suffix}");
            fs::copy(root.join(file), folder.join(&name))?;
            let text = crate::corpus::scene_with(what).replace("\"{in}\"", &toml_text(&name));
            fs::write(folder.join("odd-scene.toml"), text)?;
            for words in [
                "spectrace --width 4 --samples 1 --bands 4 odd-scene.toml odd.lux",
                "specplan --pilot 16 odd-scene.toml odd.plan",
            ] {
                let mut all = words.split(' ').map(String::from);
                let name = all.next().unwrap_or_default();
                let ended = run(&mut filter(&name, &all.collect::<Vec<_>>(), folder), b"")?;
                harmless(&format!("{name} of {what} {odd:?}"), words, &ended, folder, demands);
                if ended.status != 0 {
                    demands.broken(&format!("{name} of {what} {odd:?}: {}", ended.stderr.trim()), words);
                }
                tried += 1;
            }
            fs::remove_file(folder.join(name))?;
        }
    }
    Ok(tried)
}

/// A program is looked for by its name as it stands, an argument reaches it as it stands.
fn exec(folder: &Path, demands: &mut Demands) -> std::io::Result<usize> {
    let mut tried = 0;
    for odd in ODD {
        let texts = [
            format!("[[stage]]\nexec = [{}]\ninput = \"xyz.lux\"\noutput = \"exec.out\"\n", toml_text(odd)),
            format!(
                "[[stage]]\nexec = [\"printf\", \"%s\", {}]\ninput = \"xyz.lux\"\noutput = \"exec.out\"\n",
                toml_text(odd)
            ),
            format!(
                "[set]\nv = {}\n[[stage]]\nexec = [\"printf\", \"%s\", \"${{v}}\"]\ninput = \"xyz.lux\"\noutput = \"exec.out\"\n",
                toml_text(odd)
            ),
        ];
        for (i, text) in texts.iter().enumerate() {
            fs::write(folder.join("exec.toml"), text)?;
            let ended = shell("luxpipe --quiet exec.toml", folder)?;
            harmless(&format!("exec {i} with {odd:?}"), "luxpipe exec.toml", &ended, folder, demands);
            let got = fs::read(folder.join("exec.out")).unwrap_or_default();
            if i > 0 && (ended.status != 0 || got != odd.as_bytes()) {
                demands.broken(
                    &format!("exec {i} with {odd:?}: {} {:?}", ended.stderr.trim(), String::from_utf8_lossy(&got)),
                    "luxpipe exec.toml",
                );
            }
            let _ = fs::remove_file(folder.join("exec.out"));
            tried += 1;
        }
    }
    Ok(tried)
}

/// Devices in place of files: refused, or read within the bounds that hold for files. (A pipe that nobody writes is waited for.)
fn endless(folder: &Path, demands: &mut Demands) -> std::io::Result<usize> {
    let mut tried = 0;
    for (what, suffix) in [
        ("mesh", "obj"),
        ("mesh", "ply"),
        ("mesh", "glb"),
        ("spectrum", "csv"),
        ("matrix", "csv"),
        ("texture", "png"),
        ("sky", "hdr"),
        ("luminaire", "ies"),
        ("voxels", "vol"),
    ] {
        for target in ["/dev/zero", "/dev/urandom"] {
            let name = format!("endless.{suffix}");
            shell(&format!("rm -f {name}; ln -s {target} {name}"), folder)?;
            fs::write(folder.join("endless.toml"), crate::corpus::scene_with(what).replace("{in}", &name))?;
            let command = "ulimit -v 262144; timeout -s KILL 3 spectrace --width 4 --height 4 --samples 1 --bands 4 --threads 1 endless.toml endless.lux";
            let ended = shell(command, folder)?;
            if ended.status != 1 || ended.stderr.lines().count() != 1 {
                let said = ended.stderr.lines().next().unwrap_or("");
                let kind = format!("a {what} ({suffix}) that is {target}: status {}: {said}", ended.status);
                demands.broken(&kind, &format!("ln -s {target} {name}; {command}   # a scene that names it"));
            }
            tried += 1;
        }
    }
    Ok(tried)
}

/// What strace sees opened, beside the system's own, is what was named.
fn opened(folder: &Path, demands: &mut Demands) -> std::io::Result<usize> {
    if Command::new("strace").arg("-V").output().is_err() {
        return Ok(0);
    }
    fs::copy(crate::run::root().join("scenes/tower/mug.obj"), folder.join("named.obj"))?;
    fs::write(folder.join("named.toml"), crate::corpus::scene_with("mesh").replace("{in}", "named.obj"))?;
    fs::write(folder.join("pipe.toml"), subjects::pipeline("xyz.lux", "pipe.png"))?;
    let mut tried = 0;
    for (words, named) in [
        ("spectrace --width 4 --samples 1 named.toml named.lux", &["named.toml", "named.obj"][..]),
        ("specplan --pilot 16 named.toml named.plan", &["named.toml", "named.obj"]),
        ("luxpipe pipe.toml", &["pipe.toml", "xyz.lux"]),
        ("pcond xyz.lux pcond.lux", &["xyz.lux"]),
    ] {
        let mut all = words.split(' ');
        let name = program(all.next().unwrap_or_default());
        let mut command = Command::new("strace");
        command.args(["-f", "-qq", "-e", "trace=open,openat,execve", "-o", "calls"]).arg(name).args(all);
        run(command.current_dir(folder).env("PATH", path()), b"")?;
        let calls = fs::read_to_string(folder.join("calls"))?;
        for line in calls.lines().filter(|l| !l.contains("ENOENT")) {
            let Some(file) = line.split('"').nth(1) else { continue };
            let system =
                ["/etc/ld.so", "/lib", "/usr/lib", "/proc/", "/sys/", "/dev/"].iter().any(|p| file.starts_with(p));
            let ours = line.contains("O_TMPFILE") || line.contains("execve") || named.iter().any(|n| file.ends_with(n));
            let own_run = line.contains("execve") && calls.matches("execve").count() == 1;
            if !(system || ours) || (line.contains("execve") && !own_run) {
                demands.broken(&format!("{words}: opens {file}"), line);
            }
            tried += 1;
        }
    }
    Ok(tried)
}
