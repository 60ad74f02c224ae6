//! specmat through the real program. Expected colours: N. Ohta's blue flower and the other patches by 5 nm sums over
//! 380 to 780 nm with the CIE 1931 observer in numpy (tests/ref/README.md); figures of the paper where it prints them.

mod common;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use common::root;

fn run(args: &[&str], input: &[u8]) -> Output {
    common::run("specmat", args, input)
}

fn stdout_of(args: &[&str], input: &[u8]) -> Vec<u8> {
    common::stdout_of("specmat", args, input)
}

fn text_of(args: &[&str]) -> String {
    String::from_utf8(stdout_of(args, b"")).unwrap()
}

fn note_of(args: &[&str]) -> String {
    String::from_utf8(run(args, b"").stderr).unwrap()
}

fn fails(args: &[&str], status: i32, word: &str) {
    common::fails("specmat", args, b"", status, word);
}

/// One row of the CSV.
struct Row {
    kind: String,
    name: String,
    source: String,
    numbers: Vec<f64>,
}

impl Row {
    fn xyz(&self) -> &[f64] {
        &self.numbers[2..5]
    }
    fn absolute(&self) -> &[f64] {
        &self.numbers[5..8]
    }
    fn adjusted(&self) -> &[f64] {
        &self.numbers[8..11]
    }
    fn relative(&self) -> &[f64] {
        &self.numbers[11..14]
    }
}

fn table(args: &[&str]) -> Vec<Row> {
    let text = text_of(&[args, &["--format", "csv"]].concat());
    let mut lines = text.lines().filter(|l| !l.starts_with('#'));
    let columns = "kind,name,source,x,y,X,Y,Z,R_abs,G_abs,B_abs,R_adj,G_adj,B_adj,R_rel,G_rel,B_rel,share";
    assert_eq!(lines.next(), Some(columns));
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        assert_eq!(cells.len(), 18, "{line}");
        let numbers = cells[3..17].iter().map(|c| c.parse().unwrap()).collect();
        Row { kind: cells[0].into(), name: cells[1].into(), source: cells[2].into(), numbers }
    };
    lines.map(row).collect()
}

fn close(got: &[f64], want: &[f64], tolerance: f64) -> bool {
    got.len() == want.len() && got.iter().zip(want).all(|(a, b)| (a - b).abs() <= tolerance)
}

fn write(name: &str, text: &str) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, text).unwrap();
    (folder, path.to_str().unwrap().to_string())
}

/// The paper's whites: only these give Eq. (7) as printed.
const FLOWER: &str = r#"
[materials.flower]
reflectance = "cc_ohta_05_blue_flower"
[sources.A]
spectrum = "A"
white = [0.4475, 0.4075]
[sources.B]
spectrum = "B"
white = "0.3484,0.3516"
[sources.D65]
spectrum = "D65"
white = [0.3127, 0.3290]
"#;

#[test]
fn the_blue_flower_of_table_1() {
    let want = [
        ("B", [0.262206, 0.241394, 0.354150], [0.302105, 0.213422, 0.339674], [0.241235, 0.223007, 0.441402]),
        ("A", [0.278312, 0.237799, 0.144649], [0.464288, 0.182363, 0.119867], [0.257492, 0.217203, 0.424528]),
        ("D65", [0.258318, 0.243813, 0.453333], [0.236329, 0.225851, 0.443798], [0.236329, 0.225851, 0.443798]),
    ];
    let (_folder, list) = write("flower.toml", FLOWER);
    let rows = table(&["--quiet", &list]);
    for (source, xyz, absolute, adjusted) in want {
        let row = rows.iter().find(|r| r.kind == "material" && r.source == source).unwrap();
        assert!(close(row.xyz(), &xyz, 5e-4), "{source}: {:?}", row.xyz());
        assert!(close(row.absolute(), &absolute, 5e-4), "{source}: {:?}", row.absolute());
        assert!(close(row.adjusted(), &adjusted, 5e-4), "{source}: {:?}", row.adjusted());
    }
    // The three roads to a list agree where no white is given.
    let (_folder, csv) = write(
        "flower.csv",
        "# a comment\nkind,name,spectrum\nmaterial,flower,cc_ohta_05_blue_flower\nsource,A,A\nsource,B,B\nsource,D65,D65\n",
    );
    let words = "--material flower=cc_ohta_05_blue_flower --source A --source B --source D65 --format csv --quiet";
    let words: Vec<&str> = words.split(' ').collect();
    assert_eq!(text_of(&["--quiet", "--format", "csv", &csv]), text_of(&words));
    let bare: String = FLOWER.lines().filter(|l| !l.starts_with("white")).map(|l| format!("{l}\n")).collect();
    let (_folder, toml) = write("list", &bare);
    assert_eq!(text_of(&["--quiet", "--format", "csv", &toml]), text_of(&words));
}

/// A float picture as a renderer leaves it: the header states primaries that are not the working space's.
fn rendered(values: &[f64]) -> Vec<u8> {
    let header =
        "NCOMP=3\nCOMPONENTS=RGB\nUNITS=cd/m2\nPRIMARIES= .64 .33 .29 .60 .15 .06 .3333 .3333\nrpict scene.oct";
    let mut bytes = format!("#?RADIANCE\n{header}\nFORMAT=float\n\n-Y 1 +X {}\n", values.len() / 3).into_bytes();
    values.iter().for_each(|v| bytes.extend((*v as f32).to_le_bytes()));
    bytes
}

fn finished(stream: &[u8]) -> (String, Vec<f64>) {
    let end = stream.windows(2).position(|w| w == b"\n\n").unwrap();
    let start = end + 3 + stream[end + 2..].iter().position(|b| *b == b'\n').unwrap();
    let float = |b: &[u8]| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    (String::from_utf8(stream[..end].to_vec()).unwrap(), stream[start..].chunks_exact(4).map(float).collect())
}

#[test]
fn direct_light_of_the_dominant_source_comes_back_as_the_spectral_colour() {
    for more in [&[][..], &["--space", "BT.709"], &["--space", "XYZ"], &["--literal"], &["--space", "AP1"]] {
        for source in ["A", "FL11", "LED-RGB1", "D65"] {
            let options = [&["palettes/colorchecker.csv", "--quiet", "--source", source][..], more].concat();
            let rows = table(&options);
            let patches: Vec<&Row> = rows.iter().filter(|r| r.kind == "material").collect();
            assert_eq!(patches.len(), 24);
            // The renderer's light is white, its picture the materials' colours.
            let picture: Vec<f64> = patches.iter().flat_map(|r| r.relative().to_vec()).collect();
            let (header, got) = finished(&stdout_of(&[&options[..], &["--finish"]].concat(), &rendered(&picture)));
            let want: Vec<f64> = patches.iter().flat_map(|r| r.xyz().to_vec()).collect();
            assert!(close(&got, &want, 1e-6), "{source} {more:?}");
            let lamp = rows.iter().find(|r| r.kind == "source").unwrap();
            assert!(close(lamp.relative(), &[1.0; 3], 1e-9) || more == ["--literal"], "{:?}", lamp.relative());
            let white = header.lines().find_map(|l| l.strip_prefix("WHITE= ")).unwrap();
            let white: Vec<f64> = white.split(' ').map(|n| n.parse().unwrap()).collect();
            assert!(close(&white, &lamp.numbers[..2], 1e-8), "{header}");
            for line in ["COMPONENTS=XYZ", "UNITS=cd/m2", "rpict scene.oct"] {
                assert!(header.lines().any(|l| l == line), "{line} not in {header}");
            }
            let signed = |l: &str| l.starts_with("specmat --source ") && l.ends_with(" --finish colorchecker.csv");
            assert!(header.lines().any(signed), "{header}");
        }
    }
}

/// A second source shines in its own colour, and a white wall takes it: (Rs/Rw, Gs/Gw, Bs/Bw) x (Rw, Gw, Bw).
#[test]
fn other_sources_keep_their_colour() {
    let options = ["--quiet", "--source", "A", "--source", "D65", "--material", "white=1", "--dominant", "A"];
    let rows = table(&options);
    let d65 = rows.iter().find(|r| r.kind == "source" && r.name == "D65").unwrap();
    assert!(close(d65.absolute(), &[1.0; 3], 2e-3));
    let (_, got) = finished(&stdout_of(&[&options[..], &["--finish"]].concat(), &rendered(d65.relative())));
    assert!(close(&got, d65.xyz(), 1e-6), "{got:?}");
    assert!(d65.relative()[2] > 2.0 && d65.relative()[0] < 0.8, "blue beside tungsten: {:?}", d65.relative());
    let white = rows.iter().find(|r| r.kind == "material" && r.source == "A").unwrap();
    assert!(close(white.relative(), &[1.0; 3], 1e-9));
    let literal = table(&[&options[..], &["--literal"]].concat());
    let white = literal.iter().find(|r| r.kind == "material" && r.source == "A").unwrap();
    assert!(close(white.relative(), white.absolute(), 1e-12));
}

/// Mean, 95 % and maximum over the 300 products of two patches, independently computed (1 nm, numpy).
#[test]
fn two_bounces_err_by_one_here_and_by_fourteen_in_the_literal_form() {
    let figures = |options: &[&str], bounces: &str| -> Vec<f64> {
        let all = [&["palettes/colorchecker.csv", "--quiet", "--format", "errors"][..], options].concat();
        let text = text_of(&all);
        let rows: Vec<Vec<&str>> = text.lines().map(|l| l.split_whitespace().collect()).collect();
        let row = rows.iter().find(|r| r[0] == options[1] && r[1] == bounces).unwrap();
        row[2..].iter().map(|n| n.parse().unwrap()).collect()
    };
    let cases: [(&[&str], &str, [f64; 3]); 5] = [
        (&["--source", "A"], "2", [1.0277, 4.0984, 13.003]),
        (&["--source", "A"], "3", [1.3363, 4.6118, 12.823]),
        (&["--source", "A", "--literal"], "2", [14.428, 23.959, 32.155]),
        (&["--source", "A", "--space", "BT.709"], "2", [3.8905, 17.477, 31.387]),
        (&["--source", "FL11"], "2", [0.89722, 3.2872, 6.8204]),
    ];
    for (options, bounces, [mean, p95, max]) in cases {
        let got = figures(options, bounces);
        assert_eq!(got[0], if bounces == "2" { 300.0 } else { 2600.0 });
        for (got, want, share) in [(got[1], mean, 0.02), (got[2], p95, 0.06), (got[3], max, 0.03)] {
            assert!((got / want - 1.0).abs() < share, "{options:?} {bounces}: {got}, not {want}");
        }
        assert!(figures(options, "1")[3] < 1e-3, "direct light is exact");
    }
    let nine = ["A", "B", "C", "D50", "D65", "FL2", "FL11", "LED-B3", "LED-RGB1"];
    let mean = nine.iter().map(|s| figures(&["--source", s], "2")[1]).sum::<f64>() / 9.0;
    assert!((mean - 1.04).abs() < 0.03, "{mean}");
}

#[test]
fn radiance_reads_the_words_and_the_closing_steps_stand_above() {
    let text = text_of(&["--format", "radiance", "--quiet", "palettes/office.toml"]);
    let rows = table(&["--quiet", "palettes/office.toml"]);
    let comments: Vec<&str> = text.lines().filter(|l| l.starts_with('#')).collect();
    for word in
        ["working space BT.2020", "dominant source tubes", "(Rw,Gw,Bw) = ", "| specmat --finish", "vonkries --to D65"]
    {
        assert!(comments.iter().any(|l| l.contains(word)), "'{word}' not in {comments:?}");
    }
    let words: Vec<&str> = text.lines().filter(|l| !l.starts_with('#')).flat_map(str::split_whitespace).collect();
    let mut words = words.into_iter();
    let mut seen = Vec::new();
    while let Some(void) = words.next() {
        let mut next = || words.next().unwrap();
        assert_eq!(void, "void");
        let (kind, name) = (next(), next());
        assert_eq!((next(), next()), ("0", "0"));
        let count: usize = next().parse().unwrap();
        let numbers: Vec<f64> = (0..count).map(|_| next().parse().unwrap()).collect();
        let own =
            rows.iter().find(|r| r.name == name && r.source == if kind == "light" { name } else { "tubes" }).unwrap();
        match kind {
            "plastic" => {
                assert!(count == 5 && close(&numbers[..3], own.relative(), 1e-6) && numbers[3..] == [0.0, 0.0]);
            }
            "light" => {
                let luminance = if name == "tubes" { 6000.0 } else { 20000.0 };
                let want: Vec<f64> = own.relative().iter().map(|c| c * luminance / 179.0).collect();
                assert!(count == 3 && close(&numbers, &want, 1e-4), "{numbers:?} {want:?}");
            }
            other => panic!("{other}"),
        }
        seen.push(name);
    }
    assert_eq!(seen, ["carpet", "desk", "plant", "wall", "desk_lamp", "tubes"]);
    // The command above the materials works.
    let line = comments.iter().find_map(|l| l.split(" | ").nth(1)).unwrap();
    let args: Vec<&str> = line.split(' ').skip(1).collect();
    let (_, xyz) = finished(&stdout_of(&args, &rendered(&[1.0, 1.0, 1.0])));
    let tubes = rows.iter().find(|r| r.name == "tubes").unwrap();
    assert!(close(&xyz, tubes.xyz(), 1e-6));
}

#[test]
fn the_toml_fragment_is_toml_with_the_same_numbers() {
    let text = text_of(&["--format", "toml", "--quiet", "palettes/office.toml"]);
    let parsed: toml::Table = text.parse().unwrap();
    let numbers =
        |v: &toml::Value| -> Vec<f64> { v.as_array().unwrap().iter().map(|x| x.as_float().unwrap()).collect() };
    let rows = table(&["--quiet", "palettes/office.toml"]);
    let wall = rows.iter().find(|r| r.name == "wall" && r.source == "tubes").unwrap();
    assert!(close(&numbers(&parsed["materials"]["wall"]["rgb"]), wall.relative(), 1e-8));
    let lamp = rows.iter().find(|r| r.name == "desk_lamp").unwrap();
    assert!(close(&numbers(&parsed["lights"]["desk_lamp"]["rgb"]), lamp.relative(), 1e-8));
    let quoted = text_of(&["--format", "toml", "--source", "{ blackbody = 2856 }"]).parse::<toml::Table>().unwrap();
    assert_eq!(quoted["working"]["finish"].as_str(), Some("specmat --source '{ blackbody = 2856 }' --finish"));
    assert_eq!(parsed["working"]["space"].as_str(), Some("BT.2020"));
    assert_eq!(numbers(&parsed["working"]["primaries"])[..2], [0.708, 0.292]);
}

#[test]
fn the_dominant_source_is_chosen_and_doubted() {
    let list =
        |shares: [&str; 2]| format!("material,wall,0.5\nsource,dim,A,{}\nsource,strong,D65,{}\n", shares[0], shares[1]);
    for (shares, dominant, note) in [
        (["0.3", "0.7"], "strong", "share of 0.70"),
        (["0.1", "0.9"], "strong", ""),
        (["0.9", ""], "dim", ""),
        (["0.15", ""], "strong", ""),
        (["", ""], "dim", "no source has a share"),
    ] {
        let (_folder, path) = write("list.csv", &list(shares));
        assert!(text_of(&[&path]).contains(&format!("# dominant source {dominant} ")), "{shares:?}");
        let said = note_of(&[&path]);
        assert!(if note.is_empty() { said.is_empty() } else { said.contains(note) }, "{shares:?}: {said}");
    }
    let (_folder, path) = write("list.csv", &list(["0.1", "0.9"]));
    assert!(text_of(&[&path, "--dominant", "dim"]).contains("# dominant source dim "));
    assert!(note_of(&[&path, "--dominant", "dim"]).contains("share of 0.10"));
    let lumens = "[sources.a]\nspectrum = \"A\"\nlumens = 900\n[sources.b]\nspectrum = \"B\"\nlumens = 100\n";
    let (_folder, path) = write("list.toml", lumens);
    assert!(text_of(&[&path]).contains("# dominant source a ") && note_of(&[&path]).is_empty());
    let colours = note_of(&["--source", "A", "--material", "green=[[500,0],[520,1],[540,0]]", "--space", "BT.709"]);
    assert!(colours.contains("green") && colours.contains("wider --space"), "{colours}");
}

#[test]
fn errors_name_file_line_and_key() {
    let cases = [
        (
            "a.toml",
            "[sources.A]\nspectrum = \"Z9\"",
            "line 2, column 12: sources.A.spectrum: no built-in spectrum 'Z9'",
        ),
        ("a.toml", "[materials.w]\nreflectance = 1.2\n[sources.A]\nspectrum = \"A\"", "materials.w.reflectance"),
        (
            "a.toml",
            "[materials.A]\nreflectance = 1\n[sources.A]\nspectrum = \"A\"",
            "sources.A: the name 'A' is given twice",
        ),
        ("a.toml", "[materials.w]\nreflectance = 1", "no source"),
        ("a.toml", "[materials.\"a b\"]\nreflectance = 1", "blanks"),
        ("a.toml", "[sources.A]\nspectrum = \"A\"\nshare = 1.5", "line 3, column 9: sources.A.share"),
        ("a.toml", "[sources.A]\nspectrum = \"A\"\nlumen = 5", "sources.A.lumen: unknown key"),
        ("a.toml", "[sources.A]\nspectrum = 0", "light must be positive"),
        ("a.toml", "[sources.A]\nspectrum = [[300, 1], [310, 1]]", "no visible light"),
        ("a.toml", "[sources.A]\nspectrum = [[588, 0], [589, 1], [590, 0]]", "wider --space"),
        ("a.toml", "[sources.A]\nspectrum = \"A\"\nshare = 0.7\n[sources.B]\nspectrum = \"B\"\nlumens = 3", "not both"),
        ("a.csv", "source,A,A,0.7\nsource,B,B,0.6", "shares sum to 1.29"),
        ("a.csv", "source,A,A\nsource,A,B", "line 2: the name 'A' is given twice"),
        ("a.csv", "source,A,A\nmaterial,w,-0.1", "line 2: material 'w' runs from -0.1"),
        ("a.csv", "source,A,A\nmaterial,w", "line 2: expected 'material,NAME"),
        ("a.csv", "source,A,A,most", "line 1: share 'most'"),
        ("a.csv", "source,A,{ blackbody = }", "line 1: '{ blackbody = }'"),
        ("a.csv", "source,A,missing.csv", "line 1: cannot read 'missing.csv'"),
    ];
    for (name, text, word) in cases {
        let (_folder, path) = write(name, text);
        fails(&[&path], 1, word);
        if !word.contains("visible") && !word.contains("space") {
            fails(&[&path], 1, name);
        }
    }
    let (_folder, csv) =
        write("a.csv", "source,warm,{ blackbody = 2856 },0.9\nmaterial,ramp,[[400, 0.1], [700, 0.9]]\n");
    assert!(text_of(&[&csv]).contains("dominant source warm"));
    fails(&[], 2, "LIST");
    fails(&["none.toml"], 1, "none.toml");
    fails(&["--source", "A", "--dominant", "B"], 2, "no source 'B'; there are A");
    fails(&["--source", "A", "--source", "A"], 1, "--source: the name 'A' is given twice");
    fails(&["--source", "A", "--material", "cc_ohta_99"], 1, "--material: no built-in spectrum");
    fails(&["--source", "A", "--to", "header"], 2, "--to");
    fails(&["--source", "A", "--format", "errors"], 1, "no material");
    fails(&["--source", "A", "--finish", "--format", "csv"], 2, "--format");
    fails(&["--source", "A", "--finish"], 1, "empty input");
    let output = run(&["--source", "A", "--finish"], &fs::read(root().join("tests/data/small_xyz.lux")).unwrap());
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(1) && message.contains("the picture is XYZ"), "{message}");
}

/// Closing steps in a pipeline: one process and the shell line give the same bytes.
#[test]
fn the_closing_steps_stand_in_a_pipeline() {
    let folder = tempfile::tempdir().unwrap();
    let (input, fused, piped) =
        (folder.path().join("in.hdr"), folder.path().join("a.lux"), folder.path().join("b.lux"));
    fs::write(&input, rendered(&[0.2, 0.5, 0.7])).unwrap();
    let pipeline = |out: &Path| {
        format!(
            "[[stage]]\nrun = \"ra_rgbe\"\nreverse = true\ninput = {input:?}\n\
             [[stage]]\nrun = \"specmat\"\nlist = \"palettes/office.toml\"\nfinish = true\noutput = {out:?}\n"
        )
    };
    let bin = Path::new(env!("CARGO_BIN_EXE_luxpipe"));
    let file = folder.path().join("p.toml");
    let luxpipe = |args: &[&str]| Command::new(bin).args(args).current_dir(root()).output().unwrap();
    fs::write(&file, pipeline(&fused)).unwrap();
    let done = luxpipe(&[file.to_str().unwrap()]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    fs::write(&file, pipeline(&piped)).unwrap();
    let line = String::from_utf8(luxpipe(&["--shell", file.to_str().unwrap()]).stdout).unwrap();
    let path = format!("{}:{}", bin.parent().unwrap().display(), std::env::var("PATH").unwrap());
    let shell = Command::new("sh").args(["-c", &line]).env("PATH", path).current_dir(root()).output().unwrap();
    assert!(shell.status.success(), "{line}: {}", String::from_utf8_lossy(&shell.stderr));
    assert_eq!(fs::read(fused).unwrap(), fs::read(piped).unwrap(), "{line}");
}
