//! Text that a terminal or a browser would obey, from every place where a program takes text.

use std::fs;
use std::path::Path;

use crate::corpus;
use crate::run::{Demands, Ended, filter, root, run, shell};
use crate::subjects::toml_text;

/// A character of a text for the eye that is none: a control, or one that turns the order of letters around.
pub fn obeyed(text: &str) -> Option<char> {
    let turns = |c: char| matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    text.chars().find(|c| (c.is_control() && !matches!(c, '\n' | '\t')) || turns(*c))
}

/// What is tried: colours, a window's title, a cleared screen, C1, a bell, backspaces, a line over a line, letters turned around.
const NASTY: [&[u8]; 9] = [
    b"\x1b[31mred",
    b"\x1b]0;title\x07",
    b"\x1b[2J",
    "\u{9b}31m".as_bytes(),
    b"\x9b31m",
    b"a\x08\x08b\x7f",
    b"over\rline",
    "\u{202e}txt".as_bytes(),
    b"\x1b]8;;http://x\x1b\\y",
];

/// Keys that filters read, and lines that they do not know.
const KEYS: [&str; 16] = [
    "",
    "NOBODY=",
    "VIEW= ",
    "COMPONENTS=",
    "UNITS=",
    "WHITE= ",
    "PRIMARIES= ",
    "EXPOSURE=",
    "FORMAT=",
    "NCOMP=",
    "DISPLAY= ",
    "ADAPTED= ",
    "WAVELENGTH_SPLITS= ",
    "ROWS= ",
    "LAYERS_OF= ",
    "CAPDATE= ",
];

/// Standard error, and what a program prints for the eye, obey nothing.
fn clean(what: &str, command: &str, ended: &Ended, eye: bool, demands: &mut Demands) {
    let out = String::from_utf8_lossy(&ended.stdout);
    let shown = if eye && !ended.stdout.starts_with(b"#?") { &out } else { "" };
    for (place, text) in [("standard error", ended.stderr.as_str()), ("standard output", shown)] {
        if let Some(c) = obeyed(text) {
            let group = what.split([',', '(']).next().unwrap_or(what).trim();
            demands.broken(&format!("{group}: {place} has U+{:04X}", c as u32), &format!("{what}: {command}"));
        }
    }
}

/// A picture whose header has a line.
fn with_line(line: &[u8]) -> Vec<u8> {
    let head = b"#?RADIANCE\nNCOMP=3\nCOMPONENTS=XYZ\nUNITS=cd/m2\nWHITE= 0.3127 0.329\n";
    let tail = b"\nFORMAT=float\n\n-Y 1 +X 2\n";
    let pixels: Vec<u8> = [10f32, 11.0, 12.0, 20.0, 22.0, 24.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    [&head[..], line, tail, &pixels].concat()
}

/// Programs that read pictures, and whether what they print is for the eye.
const READERS: [(&str, &str, bool); 18] = [
    ("picinfo", "", true),
    ("picinfo", "--json", true),
    ("picinfo", "--histogram", true),
    ("pcompare", "base.lux", true),
    ("pglare", "--view -vta~-vh~180~-vv~180", true),
    ("pglare", "--json", true),
    ("vonkries", "", false),
    ("pcond", "", false),
    ("plocal", "", false),
    ("xyz2rgb", "", false),
    ("falsecolor", "", false),
    ("spec2xyz", "", false),
    ("pmix", "--weight 2", false),
    ("ra_rgbe", "", false),
    ("ra_png", "", false),
    ("ra_exr", "", false),
    ("ra_loglv", "", false),
    ("relight", "scene.toml", false),
];

fn reader(name: &str, words: &str, folder: &Path, input: &[u8]) -> std::io::Result<Ended> {
    let words: Vec<String> = words.split_whitespace().map(|w| w.replace('~', " ")).collect();
    run(&mut filter(name, &words, folder), input)
}

/// Every key with every text, through every program.
pub fn headers(folder: &Path, demands: &mut Demands) -> std::io::Result<usize> {
    fs::write(folder.join("base.lux"), with_line(b"X"))?;
    let mut tried = 0;
    for key in KEYS {
        for nasty in NASTY {
            let picture = with_line(&[key.as_bytes(), nasty].concat());
            for (name, words, eye) in READERS {
                let ended = reader(name, words, folder, &picture)?;
                clean(
                    &format!("{name} {words}, {key}"),
                    &String::from_utf8_lossy(nasty).escape_debug().to_string(),
                    &ended,
                    eye,
                    demands,
                );
                tried += 1;
            }
        }
    }
    Ok(tried)
}

/// The same lines as OpenEXR, TIFF and PNG keep them.
pub fn codings(folder: &Path, demands: &mut Demands) -> std::io::Result<usize> {
    let mut tried = 0;
    for nasty in NASTY {
        let picture = with_line(&[b"NOBODY=", nasty].concat());
        for write in ["ra_exr", "ra_loglv", "ra_pixlog", "xyz2rgb | ra_png --white-luminance 100", "ra_rgbe"] {
            fs::write(folder.join("nasty.lux"), &picture)?;
            let command = format!(
                "cat nasty.lux | {write} --quiet > nasty.bin; picinfo --quiet nasty.bin; picinfo --quiet --json nasty.bin"
            );
            clean(&format!("picinfo of {write}"), &command, &shell(&command, folder)?, true, demands);
            tried += 2;
        }
    }
    Ok(tried)
}

/// Texts that people write, with something wrong in them that a message quotes.
pub fn texts(folder: &Path, demands: &mut Demands) -> std::io::Result<usize> {
    let scene = fs::read_to_string(root().join("scenes/cornell.toml"))?;
    let mut tried = 0;
    for nasty in ["\u{1b}[31m", "\u{9b}31m", "\u{7}", "a\rb", "\u{202e}x"] {
        let quoted = toml_text(nasty);
        let scenes = [
            scene.replace("material = \"white\"", &format!("material = {quoted}")),
            scene.replace("reflectance = \"cornell_white\"", &format!("reflectance = {quoted}")),
            scene.replace("unit = \"mm\"", &format!("unit = {quoted}")),
            scene.replace("type = \"quad\"", &format!("type = {quoted}")),
            scene
                .replace("[lights.lamp]", &format!("[lights.{quoted}]"))
                .replace("light = \"lamp\"", &format!("light = {quoted}")),
            scene.replace("[materials.red]", &format!("[materials.{quoted}]")),
            format!("{quoted} = 1\n{scene}"),
            scene.replace("name = \"floor\"", &format!("name = {quoted}\nfile = 3")),
        ];
        for (i, text) in scenes.iter().enumerate() {
            fs::write(folder.join("nasty.toml"), text)?;
            for command in [
                "spectrace --width 4 --samples 1 --bands 4 nasty.toml nasty.lux",
                "specplan --pilot 16 nasty.toml -",
                "specplan --explain nasty.toml -",
                "specprobe nasty.toml",
                "relight nasty.toml layers.lux nasty.lux",
                "spectrace --width 4 --samples 1 --bands 4 --per-light --quiet nasty.toml n.lux && picinfo n.lux && relight --set x=D65 nasty.toml n.lux",
            ] {
                let name = command.split(' ').next().unwrap_or_default();
                clean(&format!("{name}, scene {i} with {nasty:?}"), command, &shell(command, folder)?, true, demands);
                tried += 1;
            }
        }
        tried += arguments(nasty, folder, demands)? + tables(nasty, folder, demands)?;
    }
    Ok(tried)
}

/// Arguments, names of files that are not there, pipelines.
fn arguments(nasty: &str, folder: &Path, demands: &mut Demands) -> std::io::Result<usize> {
    let mut tried = 0;
    for (name, words) in [
        ("vonkries", vec!["--to"]),
        ("vonkries", vec![]),
        ("pcond", vec!["--display"]),
        ("spectrace", vec!["--method"]),
        ("spectrace", vec![]),
        ("luxpipe", vec![]),
        ("luxpipe", vec!["--set"]),
        ("pplot", vec!["--spectrum"]),
        ("specmat", vec!["--material"]),
        ("picinfo", vec![]),
        ("relight", vec!["scene.toml", "--set"]),
        ("specprobe", vec!["scene.toml", "--material"]),
        ("ra_png", vec!["--tmp"]),
        ("tradeoff", vec!["-o", "x"]),
    ] {
        for form in [nasty.to_string(), format!("--{nasty}"), format!("x={nasty}")] {
            let words: Vec<String> = words.iter().map(|w| w.to_string()).chain([form]).collect();
            let ended = run(&mut filter(name, &words, folder), b"")?;
            clean(&format!("{name} with an argument, {nasty:?}"), &format!("{words:?}"), &ended, true, demands);
            tried += 1;
        }
    }
    let quoted = toml_text(nasty);
    for text in [
        format!("name = {quoted}\n[[stage]]\nrun = \"vonkries\"\ninput = \"xyz.lux\"\noutput = {quoted}\n"),
        format!("[[stage]]\nrun = {quoted}\n"),
        format!("{quoted} = 1\n"),
        format!("[[stage]]\nrun = \"vonkries\"\n{quoted} = 1\n"),
        format!("[set]\n{quoted} = 1\n"),
        format!("[[stage]]\nexec = [{quoted}]\ninput = \"xyz.lux\"\noutput = \"o\"\n"),
        format!("[[stage]]\nrun = \"vonkries\"\ninput = {quoted}\noutput = \"o\"\n"),
    ] {
        fs::write(folder.join("nasty.toml"), text)?;
        for option in ["", "--dry-run", "--shell", "--make", "--snakemake"] {
            let ended = shell(&format!("luxpipe {option} nasty.toml"), folder)?;
            // What is printed for other programs quotes names as they are: a message does not.
            let eye = option == "--dry-run";
            clean(&format!("luxpipe {option}, {nasty:?}"), option, &ended, eye, demands);
            tried += 1;
        }
    }
    Ok(tried)
}

/// Tables and meshes.
fn tables(nasty: &str, folder: &Path, demands: &mut Demands) -> std::io::Result<usize> {
    let files = [
        ("n.obj", format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 {nasty}\n{nasty}\n")),
        ("n.ply", format!("ply\nformat ascii 1.0\nelement {nasty} 3\n{nasty}\nend_header\n")),
        ("n.csv", format!("400,0.5\n{nasty},3\n")),
        ("n.ies", format!("IESNA:LM-63-2002\n[TEST] {nasty}\nTILT={nasty}\n1 2 3\n")),
        (
            "n.gltf",
            format!(
                "{{\"asset\":{{\"version\":\"{}\"}},\"scene\":\"x{}\"}}",
                nasty.escape_unicode(),
                nasty.escape_unicode()
            ),
        ),
    ];
    let mut tried = 0;
    for (name, text) in files {
        fs::write(folder.join(name), text)?;
        let kind = if name.ends_with("csv") {
            "spectrum"
        } else if name.ends_with("ies") {
            "luminaire"
        } else {
            "mesh"
        };
        fs::write(folder.join("n.toml"), corpus::scene_with(kind).replace("{in}", name))?;
        for command in [
            "spectrace --width 4 --samples 1 n.toml n.lux".to_string(),
            format!("pplot --spectrum {name} n.svg"),
            format!("pplot --chart {name} n.svg"),
            format!("pdisplay {name}"),
            format!("specmat {name}"),
            format!("pcond --calibration {name} xyz.lux x.lux"),
            format!("pcond --histogram {name} xyz.lux x.lux"),
            format!("vonkries --display {name} xyz.lux x.lux"),
            format!("spectrace --plan {name} scene.toml n.lux"),
        ] {
            clean(
                &format!("{} of {name}, {nasty:?}", command.split(' ').next().unwrap_or("")),
                &command,
                &shell(&command, folder)?,
                true,
                demands,
            );
            tried += 1;
        }
    }
    Ok(tried)
}

/// Markup in names and titles comes out as text.
pub fn markup(folder: &Path, demands: &mut Demands) -> std::io::Result<usize> {
    let nasty = "<img src=x onerror=alert(1)>\"'&</text></svg><script>alert(2)</script>";
    let file = "<img src=x onerror=alert(1)>&\"'";
    fs::copy(folder.join("scene.toml"), folder.join(format!("{file}.toml")))?;
    fs::write(folder.join("m.csv"), format!("{nasty},y,by\n1,2,{nasty}\n2,3,{nasty}\n3,4,b\n"))?;
    let words = |text: &str| {
        text.split(' ')
            .map(|w| w.replace("{nasty}", nasty).replace("{plain}", "<b>&\"'<script>alert(2)").replace("{file}", file))
            .collect::<Vec<_>>()
    };
    let mut tried = 0;
    for (name, command) in [
        ("pplot", "--spectrum {plain}=D65 --title {nasty} --labels {nasty},{nasty} m.svg"),
        ("pplot", "--chart m.csv --x {nasty} --y y --by by m.svg"),
        ("pplot", "--chart {plain}=m.csv --y y m.svg"),
        (
            "tradeoff",
            "{file}.toml --width 8 --samples 1 --methods local --plans none --seconds 0.01 --reference-seconds 0.01 -o page --filters",
        ),
    ] {
        let ended = run(&mut filter(name, &words(command), folder), b"")?;
        let made = shell("cat m.svg page/*.html page/*.svg 2> /dev/null", folder)?;
        let text = String::from_utf8_lossy(&made.stdout).to_lowercase();
        if ended.status != 0 {
            demands.broken(&format!("{name} with markup: status {}: {}", ended.status, ended.stderr.trim()), command);
        }
        if text.contains("<img src=x") || text.contains("<script>alert") || text.contains("\"'&<") {
            demands.broken(&format!("{name}: markup comes out as markup"), command);
        }
        let _ = fs::remove_file(folder.join("m.svg"));
        tried += 1;
    }
    Ok(tried)
}
