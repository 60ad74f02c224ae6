//! Damaged files through the real programs, thousands a program: no panic, no hang, no memory beyond a bound, one line where a file is
//! refused, nothing left behind, and no visible damage (see [`crate::guard`]) that passes unseen.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use crate::corpus::Seed;
use crate::mutate::{Damage, damaged};
use crate::readers::{self, Reader};
use crate::run::{Choice, Demands, Random, keep, machine, path, program, quote, run};

/// Address space of a program, KiB.
const MEMORY: usize = 256 << 10;
/// A run over so many seconds is a hang, of processor time and (seen alone) on the clock.
const SECONDS: u64 = 2;
/// Files that one shell runs.
const BATCH: usize = 50;

/// What a program did with a file.
pub struct Outcome {
    /// As a shell counts it.
    pub status: i32,
    /// Standard error.
    pub said: String,
    /// The output.
    pub out: Option<Vec<u8>>,
}

/// A whole file and what comes of it.
struct Good {
    seed: Arc<Seed>,
    out: Option<Vec<u8>>,
}

/// Files of one reader for one shell: which whole file, and where random numbers begin.
struct Batch {
    reader: usize,
    files: Vec<(usize, u64)>,
}

/// Counts of a program.
#[derive(Default)]
struct Row {
    files: usize,
    refused: usize,
    noted: usize,
    seconds: f64,
    broken: BTreeMap<&'static str, usize>,
}

/// Runs all of it and prints a table.
pub fn section(choice: &Choice, demands: &mut Demands) -> std::io::Result<()> {
    let begin = Instant::now();
    let first = tempfile::tempdir()?;
    readers::companions(first.path())?;
    let readers = readers::all(first.path())?;
    let goods = readers.iter().map(|r| whole(r, first.path())).collect::<std::io::Result<Vec<_>>>()?;
    for (reader, _) in readers.iter().zip(&goods).filter(|(_, g)| g.is_empty()) {
        demands.broken(&format!("{}: reads none of its whole files", reader.program), &reader.words.join(" "));
    }
    let programs: Vec<&str> = {
        let mut all: Vec<&str> = readers.iter().map(|r| r.program).collect();
        all.sort();
        all.dedup();
        all
    };
    let batches = Mutex::new(batches(&readers, &goods, choice));
    let rows: Mutex<BTreeMap<&str, Row>> = Mutex::default();
    let demands = Mutex::new(demands);
    std::thread::scope(|s| {
        let work = || -> std::io::Result<()> {
            let folder = tempfile::tempdir()?;
            readers::companions(folder.path())?;
            fs::copy(first.path().join("layers.lux"), folder.path().join("layers.lux"))?;
            while let Some(batch) = { batches.lock().ok().and_then(|mut b| b.pop()) } {
                let reader = &readers[batch.reader];
                let goods = &goods[batch.reader];
                let began = Instant::now();
                let all = one_batch(reader, goods, &batch, folder.path())?;
                let (mut rows, mut demands) = (rows.lock().unwrap(), demands.lock().unwrap());
                let row = rows.entry(reader.program).or_default();
                row.seconds += began.elapsed().as_secs_f64();
                for judged in &all {
                    count(row, judged);
                    tell(reader, judged, &mut demands, folder.path())?;
                }
            }
            Ok(())
        };
        let threads: Vec<_> = (0..2).map(|_| s.spawn(work)).collect();
        threads.into_iter().try_for_each(|t| t.join().expect("a worker"))
    })?;
    print(&programs, &rows.into_inner().unwrap(), choice, begin.elapsed());
    Ok(())
}

/// The whole files that a reader takes, and what comes of them.
fn whole(reader: &Reader, folder: &Path) -> std::io::Result<Vec<Good>> {
    let files: Vec<&[u8]> = reader.seeds.iter().map(|s| &s.bytes[..]).collect();
    let suffixes: Vec<&str> = reader.seeds.iter().map(|s| s.suffix.as_str()).collect();
    let outcomes = run_all(reader, &files, &suffixes, folder)?;
    if let Some(o) = outcomes.first().filter(|_| outcomes.iter().all(|o| o.status != 0)) {
        eprintln!("trust: {} {}: {}", reader.program, reader.words.join(" "), o.said.trim());
    }
    let pairs = reader.seeds.iter().zip(outcomes).filter(|(_, o)| o.status == 0);
    Ok(pairs.map(|(seed, o)| Good { seed: seed.clone(), out: o.out }).collect())
}

/// All work in an order that lets slow programs begin early.
fn batches(readers: &[Reader], goods: &[Vec<Good>], choice: &Choice) -> Vec<Batch> {
    let mut all = Vec::new();
    for (i, reader) in readers.iter().enumerate() {
        let share = readers.iter().filter(|r| r.program == reader.program).count();
        let mut random = Random(choice.seed.wrapping_mul(1 << 20).wrapping_add(i as u64));
        let n = goods[i].len();
        // tradeoff renders references besides: a batch of it takes seconds.
        let count = if n == 0 { 0 } else { choice.count.div_ceil(share) };
        let files: Vec<(usize, u64)> = (0..count).map(|k| (k % n.max(1), random.next())).collect();
        all.extend(files.chunks(BATCH).map(|c| Batch { reader: i, files: c.to_vec() }));
    }
    all
}

/// A damaged file, what was done to it, what came of it, and what is wrong with that.
struct Judged {
    bytes: Vec<u8>,
    suffix: String,
    what: String,
    outcome: Outcome,
    broken: Option<&'static str>,
}

fn one_batch(reader: &Reader, goods: &[Good], batch: &Batch, folder: &Path) -> std::io::Result<Vec<Judged>> {
    let make = |(i, seed): &(usize, u64)| {
        let good = &goods[*i];
        let (bytes, damage) = damaged(&good.seed.bytes, good.seed.text, &good.seed.guard, &mut Random(*seed));
        (good, bytes, damage)
    };
    let files: Vec<(&Good, Vec<u8>, Damage)> = batch.files.iter().map(make).collect();
    let bytes: Vec<&[u8]> = files.iter().map(|f| &f.1[..]).collect();
    let suffixes: Vec<&str> = files.iter().map(|f| f.0.seed.suffix.as_str()).collect();
    let outcomes = run_all(reader, &bytes, &suffixes, folder)?;
    let judge = |((good, bytes, damage), outcome): ((&Good, Vec<u8>, Damage), Outcome)| {
        let broken = broken(reader, good, &damage, &outcome);
        let what = format!("{}, {}", good.seed.name, damage.what);
        Judged { bytes, suffix: good.seed.suffix.clone(), what, outcome, broken }
    };
    Ok(files.into_iter().zip(outcomes).map(judge).collect())
}

/// The demand that an outcome breaks.
fn broken(reader: &Reader, good: &Good, damage: &Damage, o: &Outcome) -> Option<&'static str> {
    let one_line = o.said.lines().count() == 1 && o.said.starts_with(&format!("{}: ", reader.program));
    let has = |word: &str| reader.words.iter().any(|w| w == word);
    match o.status {
        _ if o.said.contains("panicked") || o.status == 101 => Some("panics"),
        _ if o.said.contains("memory allocation") || o.said.contains("overflowed its stack") => Some("memory"),
        137 | 152 => Some("hangs"),
        3.. => Some("ends by a signal"),
        1 | 2 if !one_line => Some("does not say it in one line"),
        // A verdict, after all is written.
        1 | 2 if o.out.is_some() && !has("--check") && reader.program != "tradeoff" => Some("leaves a file"),
        0 if has("{out}") && o.out.is_none() && reader.program != "tradeoff" => Some("leaves no file"),
        0 if damage.visible && o.said.is_empty() && o.out != good.out => Some("says nothing"),
        _ => None,
    }
}

fn count(row: &mut Row, judged: &Judged) {
    row.files += 1;
    row.refused += usize::from(matches!(judged.outcome.status, 1 | 2));
    row.noted += usize::from(judged.outcome.status == 0 && !judged.outcome.said.is_empty());
    if let Some(broken) = judged.broken {
        *row.broken.entry(broken).or_default() += 1;
    }
}

/// Keeps the first file of each kind of finding, with the command that shows it.
fn tell(reader: &Reader, judged: &Judged, demands: &mut Demands, folder: &Path) -> std::io::Result<()> {
    let Some(broken) = judged.broken else { return Ok(()) };
    let said: String = judged
        .outcome
        .said
        .lines()
        .next()
        .unwrap_or("")
        .chars()
        .map(|c| if c.is_ascii_digit() { '0' } else { c })
        .collect();
    let place = said.replace(&folder.display().to_string(), "").chars().take(70).collect::<String>();
    let form = judged.suffix.trim_start_matches('.');
    let kind = format!(
        "{} {} {broken}: {}",
        reader.program,
        form,
        place.replace("00", "0").replace("00", "0").replace("00", "0")
    );
    let name = format!("{}-{}-{:08x}{}", reader.program, broken.replace(' ', "-"), hash(&judged.bytes), judged.suffix);
    let mut command = String::new();
    if !demands.knows(&kind) {
        let file = keep(&name, &judged.bytes)?.display().to_string();
        let side = reader.side.as_ref().map(|text| {
            keep(&format!("{name}.side.toml"), text.replace("{in}", &file).replace("{out}", "/tmp/out").as_bytes())
        });
        let side = side.transpose()?.map_or(String::new(), |p| p.display().to_string());
        let command_line = words(reader, &file, "/tmp/out", &side);
        command = format!(
            "{command_line} --threads 1   # {}: status {}, {}",
            judged.what,
            judged.outcome.status,
            judged.outcome.said.trim()
        );
    }
    demands.broken(&kind, &command);
    Ok(())
}

fn hash(bytes: &[u8]) -> u32 {
    bytes.iter().fold(2_166_136_261, |h, b| (h ^ u32::from(*b)).wrapping_mul(16_777_619))
}

/// A command as a shell takes it, the damaged file named.
fn words(reader: &Reader, file: &str, out: &str, side: &str) -> String {
    let word = |w: &String| quote(&w.replace("{in}", file).replace("{out}", out).replace("{side}", side));
    let all: Vec<String> = reader.words.iter().map(word).collect();
    let stdin = if reader.stdin { quote(file) } else { "/dev/null".into() };
    format!("{} {} < {stdin}", quote(&program(reader.program).display().to_string()), all.join(" "))
}

/// Runs a reader on each file, all by one shell in little memory and time.
fn run_all(reader: &Reader, files: &[&[u8]], suffixes: &[&str], folder: &Path) -> std::io::Result<Vec<Outcome>> {
    let before = fs::read_dir(folder)?.count();
    let mut script = format!("ulimit -v {MEMORY}; ulimit -t {SECONDS}; exec 3> status\n");
    let (name, out) = (|i: usize| format!("f{i}{}", suffixes[i]), |i: usize| format!("o{i}"));
    for (i, bytes) in files.iter().enumerate() {
        fs::write(folder.join(name(i)), bytes)?;
        let side = format!("s{i}.toml");
        if let Some(text) = &reader.side {
            fs::write(folder.join(&side), text.replace("{in}", &name(i)).replace("{out}", &out(i)))?;
        }
        script += &format!("{} --threads 1 > p{i} 2> e{i}; echo $? >&3\n", words(reader, &name(i), &out(i), &side));
    }
    watched(&script, files.len(), folder)?;
    let statuses = fs::read_to_string(folder.join("status"))?;
    let mut all = Vec::new();
    for (i, status) in statuses.lines().enumerate() {
        let said = String::from_utf8_lossy(&fs::read(folder.join(format!("e{i}")))?).into_owned();
        let file = folder.join(out(i));
        let whole = fs::read(&file).or_else(|_| {
            fs::read(folder.join(format!("p{i}"))).and_then(|b| {
                if b.is_empty() || reader.words.iter().any(|w| w == "{out}") {
                    Err(std::io::ErrorKind::NotFound.into())
                } else {
                    Ok(b)
                }
            })
        });
        let mut outcome = Outcome { status: status.parse().unwrap_or(255), said, out: whole.ok() };
        if matches!(outcome.status, 137 | 152) && !slow_alone(reader, &name(i), i, folder)? {
            outcome.status = 0; // the machine was busy
        }
        all.push(outcome);
    }
    sweep(files.len(), suffixes, folder)?;
    let left = fs::read_dir(folder)?.count();
    // What pipelines and trade-offs write has names of its own.
    if left != before
        && !["luxpipe", "tradeoff"].contains(&reader.program)
        && !reader.words.iter().any(|w| w == "--checkpoint" || w == "--solution")
    {
        let names: Vec<_> = fs::read_dir(folder)?.flatten().map(|e| e.file_name()).collect();
        eprintln!("trust: {} left files: {names:?}", reader.program);
    }
    Ok(all)
}

/// Runs the shell; a program that does not end by the clock either is killed.
fn watched(script: &str, files: usize, folder: &Path) -> std::io::Result<()> {
    let file = folder.join("script");
    fs::write(&file, script)?;
    let mut command = Command::new("sh");
    command
        .arg("script")
        .current_dir(folder)
        .env("PATH", path())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    let mut child = command.spawn()?;
    let (mut done, mut since) = (0, Instant::now());
    while child.try_wait()?.is_none() {
        let length = fs::metadata(folder.join("status")).map_or(0, |m| m.len());
        if length != done {
            (done, since) = (length, Instant::now());
        }
        if since.elapsed() > Duration::from_secs(5 * SECONDS) {
            for pid in crate::run::family(child.id()).into_iter().skip(1) {
                run(Command::new("kill").args(["-9", &pid.to_string()]), b"")?;
            }
            since = Instant::now();
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let lines = fs::read_to_string(folder.join("status"))?.lines().count();
    if lines == files {
        Ok(())
    } else {
        Err(std::io::Error::other(format!("{lines} of {files} runs: {}", file.display())))
    }
}

/// Does it take too long with the clock running?
fn slow_alone(reader: &Reader, file: &str, i: usize, folder: &Path) -> std::io::Result<bool> {
    let command = words(reader, file, "again", &format!("s{i}.toml"));
    let begin = Instant::now();
    run(
        Command::new("sh")
            .args(["-c", &format!("ulimit -t 5; timeout -s KILL 10 {command} --threads 1")])
            .current_dir(folder),
        b"",
    )?;
    let _ = fs::remove_file(folder.join("again"));
    Ok(begin.elapsed() > Duration::from_secs(SECONDS))
}

/// Takes the files of a batch away.
fn sweep(files: usize, suffixes: &[&str], folder: &Path) -> std::io::Result<()> {
    for (i, suffix) in suffixes.iter().enumerate().take(files) {
        for name in [format!("f{i}{suffix}"), format!("s{i}.toml"), format!("o{i}"), format!("e{i}"), format!("p{i}")] {
            let path = folder.join(name);
            let _ = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
        }
    }
    fs::remove_file(folder.join("status"))?;
    fs::remove_file(folder.join("script"))
}

fn print(programs: &[&str], rows: &BTreeMap<&str, Row>, choice: &Choice, took: Duration) {
    println!(
        "## Damaged files\n\n{}; {} files a program, seed {}, {} s.\n",
        machine(),
        choice.count,
        choice.seed,
        took.as_secs()
    );
    println!(
        "| program | files | refused | read | of these with a note | panics | hangs | memory | signals | other | silent | ms a file |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|");
    for name in programs {
        let Some(row) = rows.get(name) else { continue };
        let of = |kinds: &[&str]| kinds.iter().filter_map(|k| row.broken.get(k)).sum::<usize>();
        let other = of(&["does not say it in one line", "leaves a file", "leaves no file"]);
        let [panics, hangs, memory] = ["panics", "hangs", "memory"].map(|k| of(&[k]));
        let (signals, silent, read) = (of(&["ends by a signal"]), of(&["says nothing"]), row.files - row.refused);
        println!(
            "| {name} | {} | {} | {read} | {} | {panics} | {hangs} | {memory} | {signals} | {other} | {silent} | {:.1} |",
            row.files,
            row.refused,
            row.noted,
            1000.0 * row.seconds / row.files as f64
        );
    }
}
