//! Damage, through the real programs: to every encoding that a filter writes and to every file of tests/data. What is cut is
//! refused and its row named, what follows the picture is told, and no bit makes a filter fail in any other way than by one line
//! and status 1, in little memory.

mod common;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use common::{data_path, encodings, floats, program, root, run, split, stdout_of, stream};

/// A whole file and the filter that reads it with `-r`.
struct Good {
    name: String,
    filter: &'static str,
    bytes: Vec<u8>,
    /// Made by our own filters: one picture and nothing else.
    ours: bool,
}

/// Address space of a filter, KiB.
const MEMORY: u32 = 256 << 10;
/// Rows of our own pictures.
const ROWS: usize = 9;

/// 20 x 9 pixels in a form that one encoding or another takes: colours, a spectrum, light for a display.
fn pictures() -> [Vec<u8>; 3] {
    let values = |n: usize, top: f32| -> Vec<f32> {
        (0..20 * ROWS * n).map(|i| top * (0.1 + 0.9 * ((i * 7919 % 997) as f32 / 997.0))).collect()
    };
    let size = format!("-Y {ROWS} +X 20");
    let white = "WHITE= 0.3127 0.329\nVIEW= -vtv -vh 40 -vv 30";
    [
        stream(&format!("NCOMP=3\nCOMPONENTS=XYZ\nUNITS=cd/m2\n{white}"), &size, &values(3, 90.0)),
        stream("NCOMP=5\nCOMPONENTS=SPECTRUM\nWAVELENGTH_SPLITS= 780 588 480 380", &size, &values(5, 0.1)),
        stream(
            "NCOMP=3\nCOMPONENTS=RGB\nUNITS=display\nPRIMARIES= .64 .33 .3 .6 .15 .06 .3127 .329",
            &size,
            &values(3, 1.0),
        ),
    ]
}

/// A file of each encoding.
fn ours() -> Vec<Good> {
    let pictures = pictures();
    let mut all: Vec<Good> = encodings()
        .iter()
        .map(|e| Good {
            name: e.to_string(),
            filter: e.filter,
            bytes: pictures.iter().find_map(|p| e.try_write(p).ok()).unwrap_or_else(|| panic!("{e} takes no picture")),
            ours: true,
        })
        .collect();
    all.push(Good { name: "stream".into(), filter: "ra_rgbe", bytes: pictures[0].clone(), ours: true });
    all
}

/// The small pictures of tests/data.
fn theirs() -> Vec<Good> {
    fn walk(folder: &Path, files: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() { walk(&path, files) } else { files.push(path) }
        }
    }
    let mut files = Vec::new();
    walk(&root().join("tests/data"), &mut files);
    files.sort();
    let read = |path: &PathBuf| {
        let bytes = fs::read(path).unwrap();
        let name = path.strip_prefix(root().join("tests/data")).unwrap().display().to_string();
        let picture = bytes.len() < 20_000 && run("ra_rgbe", &["-r", "-", "/dev/null"], &bytes).status.success();
        picture.then_some(Good { name, filter: "ra_rgbe", bytes, ours: false })
    };
    let all: Vec<Good> = files.iter().filter_map(read).collect();
    assert!(all.len() > 25, "{} pictures", all.len());
    all
}

/// What a filter made of a damaged file.
struct Outcome {
    status: i32,
    message: String,
    picture: Option<Vec<u8>>,
}

/// Reads each of `files` with the filter to a file, in little memory. One shell runs them all.
fn read_all(good: &Good, files: &[Vec<u8>]) -> Vec<Outcome> {
    let folder = tempfile::tempdir().unwrap();
    let at = |i: usize, suffix: &str| folder.path().join(format!("{i}.{suffix}"));
    files.iter().enumerate().for_each(|(i, bytes)| fs::write(at(i, "in"), bytes).unwrap());
    let script = "ulimit -v $2 && i=0 && while [ $i -lt $3 ]; do
        $0 -r --threads 1 $1/$i.in $1/$i.out 2> $1/$i.err; echo $? > $1/$i.status; i=$((i + 1)); done";
    let shell = Command::new("sh")
        .args(["-c", script])
        .arg(program(good.filter))
        .arg(folder.path())
        .args([MEMORY.to_string(), files.len().to_string()])
        .status();
    assert!(shell.unwrap().success());
    let text = |path: PathBuf| String::from_utf8_lossy(&fs::read(path).unwrap()).into_owned();
    let entries = fs::read_dir(folder.path()).unwrap().count();
    let outcome = |i: usize| Outcome {
        status: text(at(i, "status")).trim().parse().unwrap(),
        message: text(at(i, "err")).replace(&format!("{}/", folder.path().display()), ""),
        picture: fs::read(at(i, "out")).ok(),
    };
    let all: Vec<Outcome> = (0..files.len()).map(outcome).collect();
    let written = all.iter().filter(|o| o.picture.is_some()).count();
    let ended: Vec<i32> = all.iter().map(|o| o.status).filter(|s| *s > 1).collect();
    assert!(ended.is_empty(), "{}: a filter ended with status {ended:?}", good.name);
    assert_eq!(entries, 3 * files.len() + written, "{}: files are left beside those asked for", good.name);
    all
}

/// Status 1, one line, no file.
fn refused(o: &Outcome, good: &Good, damage: &str) {
    assert_eq!(o.status, 1, "{} {damage}: {}", good.name, o.message);
    assert_eq!(o.message.lines().count(), 1, "{} {damage}: {}", good.name, o.message);
    assert!(o.message.starts_with(&format!("{}: ", good.filter)), "{} {damage}: {}", good.name, o.message);
    assert!(o.picture.is_none(), "{} {damage} left a file", good.name);
}

/// About sixty lengths to cut at, close together at both ends.
fn lengths(total: usize) -> Vec<usize> {
    let (head, tail) = (total.min(12), total.saturating_sub(12));
    let mut all: Vec<usize> = (0..head).chain(tail..total).chain((0..36).map(|i| total * i / 36)).collect();
    all.sort();
    all.dedup();
    all
}

#[test]
fn what_is_cut_is_refused_and_its_row_named() {
    for good in ours() {
        let lengths = lengths(good.bytes.len());
        let files: Vec<Vec<u8>> = lengths.iter().map(|n| good.bytes[..*n].to_vec()).collect();
        let outcomes = read_all(&good, &files);
        let mut named = 0;
        for (o, length) in outcomes.iter().zip(&lengths) {
            refused(o, &good, &format!("cut at {length}"));
            let row = (1..=ROWS).any(|r| o.message.contains(&format!("row {r} of {ROWS}")));
            // From the first pixel on every cut is in some row.
            assert!(row || named == 0, "{} cut at {length}: {}", good.name, o.message);
            named += usize::from(row);
        }
        // TIFF's directory, without which nothing is known, comes last.
        let tiff = good.bytes.starts_with(b"II");
        assert!(tiff || named > 10, "{}: a row was named {named} times", good.name);
    }
    // The row is the one where they end: 20 pixels of 12 bytes a row, two rows and one byte left.
    let [xyz, ..] = pictures();
    let good = Good { name: "stream".into(), filter: "ra_rgbe", bytes: xyz, ours: true };
    let end = good.bytes.len() - 240 * (ROWS - 2);
    let o = &read_all(&good, &[good.bytes[..end + 1].to_vec()])[0];
    assert!(o.message.contains("row 3 of 9"), "{}", o.message);
}

/// Of files of other programs some parts are not read at all; what is read is whole or refused.
#[test]
fn cut_files_of_other_programs_are_whole_or_refused() {
    for good in theirs() {
        let lengths: Vec<usize> = lengths(good.bytes.len()).into_iter().step_by(3).collect();
        let files = lengths.iter().map(|n| good.bytes[..*n].to_vec()).chain([good.bytes.clone()]);
        let outcomes = read_all(&good, &files.collect::<Vec<_>>());
        let whole = &outcomes.last().unwrap().picture;
        for (o, length) in outcomes.iter().zip(&lengths) {
            if o.status == 0 {
                assert!(o.picture == *whole, "{} cut at {length} gives another picture", good.name);
            } else {
                refused(o, &good, &format!("cut at {length}"));
            }
        }
        assert!(outcomes.iter().filter(|o| o.status == 1).count() > 10, "{}", good.name);
    }
}

#[test]
fn what_follows_a_picture_is_told() {
    for good in ours().into_iter().chain(theirs()) {
        let junk: Vec<u8> = (1..=100).collect();
        let outcomes = read_all(&good, &[good.bytes.clone(), [&good.bytes[..], &junk].concat()]);
        let [whole, more] = &outcomes[..] else { panic!() };
        assert_eq!(whole.status, 0, "{}: {}", good.name, whole.message);
        assert!(!good.ours || !whole.message.contains("ignored"), "{}: {}", good.name, whole.message);
        if more.status == 1 {
            refused(more, &good, "and more");
            continue;
        }
        assert!(whole.picture == more.picture, "{}", good.name);
        // Where more pictures follow anyway nobody can tell.
        let several = more.message.contains("first of") || good.name == "exr/sizes.exr";
        let told = more.message.lines().filter(|l| l.contains("ignored") && l.contains("after")).count();
        assert!(told == 1 || (several && !good.ours), "{}: {}", good.name, more.message);
    }
}

#[test]
fn a_wrong_bit_is_an_error_or_a_picture() {
    let mut seed = 1u64;
    for good in ours().into_iter().chain(theirs()) {
        let flips = if good.ours { 60 } else { 8 };
        let flipped = |_| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let mut bytes = good.bytes.clone();
            // Half of them near the beginning, where sizes and offsets are.
            let within = if seed >> 63 == 0 { bytes.len() } else { bytes.len().min(400) };
            let at = (seed >> 20) as usize % within;
            bytes[at] ^= 1 << (seed >> 60 & 7);
            (at, bytes)
        };
        let (places, files): (Vec<usize>, Vec<Vec<u8>>) = (0..flips).map(flipped).unzip();
        for (o, at) in read_all(&good, &files).iter().zip(places) {
            let damage = format!("a bit of byte {at}");
            match o.status {
                0 => assert!(o.picture.is_some() && !o.message.contains("panic"), "{} {damage}", good.name),
                _ => refused(o, &good, &damage),
            }
        }
    }
}

/// A TIFF: its bytes after the head, then tags of one 32-bit number, then lists.
fn tiff(data: &[u8], numbers: &[(u16, u32)], lists: &[(u16, Vec<u32>)]) -> Vec<u8> {
    let mut file = b"II*\0\0\0\0\0".to_vec();
    file.extend(data);
    let mut entries: Vec<(u16, u32, u32)> = numbers.iter().map(|(tag, n)| (*tag, 1, *n)).collect();
    for (tag, list) in lists {
        entries.push((*tag, list.len() as u32, if list.len() == 1 { list[0] } else { file.len() as u32 }));
        file.extend(list.iter().flat_map(|n| n.to_le_bytes()));
    }
    let at = (file.len() as u32).to_le_bytes();
    file[4..8].copy_from_slice(&at);
    entries.sort();
    file.extend((entries.len() as u16).to_le_bytes());
    for (tag, count, value) in entries {
        file.extend([tag.to_le_bytes(), 4u16.to_le_bytes()].concat());
        file.extend([count.to_le_bytes(), value.to_le_bytes()].concat());
    }
    file.extend([0; 4]);
    file
}

/// Tags of Pixar log or of LogLuv's luminances.
fn tags(pixar: bool, width: u32, height: u32) -> Vec<(u16, u32)> {
    let kind = if pixar { [(259, 32909), (262, 2), (277, 3)] } else { [(259, 34676), (262, 32844), (277, 1)] };
    [&kind[..], &[(256, width), (257, height)]].concat()
}

/// Small files that claim much by naming the same bytes often, by decoders side by side, or by rows of unheard length.
#[test]
fn a_small_tiff_claims_no_more_than_it_holds() {
    let zeros = {
        let mut z = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
        std::io::Write::write_all(&mut z, &[0; 6]).unwrap();
        z.finish().unwrap()
    };
    let count = zeros.len() as u32;
    let many = |n: u32, data: &[u8]| data.repeat(n as usize);
    let offsets = |n: u32| (0..n).map(|i| 8 + i * count).collect::<Vec<u32>>();
    let good = Good { name: "a TIFF".into(), filter: "ra_pixlog", bytes: Vec::new(), ours: false };
    let cases = [
        ("strips that are one", "lie upon each other", {
            let list = [(273, vec![8; 5000]), (279, vec![50_000; 5000])];
            tiff(&[0; 50_000], &[&tags(true, 1, 5000)[..], &[(278, 1)]].concat(), &list)
        }),
        ("tiles that are one", "lie upon each other", {
            let list = [(324, vec![8; 5000]), (325, vec![50_000; 5000])];
            tiff(&[1; 50_000], &[&tags(false, 5000, 16)[..], &[(322, 1), (323, 16)]].concat(), &list)
        }),
        ("a row too long", "too long", {
            let numbers = [&tags(false, i32::MAX as u32, 1)[..], &[(278, 1)]].concat();
            tiff(&[0; 100], &numbers, &[(273, vec![8]), (279, vec![100])])
        }),
        ("a strip too small", "row 1 of 2147483647", {
            let numbers = [&tags(true, 1 << 26, i32::MAX as u32)[..], &[(278, i32::MAX as u32)]].concat();
            tiff(&[0; 100], &numbers, &[(273, vec![8]), (279, vec![100])])
        }),
        ("tiles too wide", "at most 89478485", {
            let numbers = [&tags(true, 5, 5)[..], &[(322, i32::MAX as u32), (323, 5)]].concat();
            tiff(&[0; 100], &numbers, &[(324, vec![8]), (325, vec![100])])
        }),
        ("a strip beyond the end", "picture ends at row 3 of 5", {
            let list = [(273, vec![8, 10, 1 << 20, 12, 14]), (279, vec![4; 5])];
            tiff(&[1; 40], &[&tags(false, 1, 5)[..], &[(278, 1)]].concat(), &list)
        }),
        ("no room for a row", "row 1 of 5", {
            tiff(&[0; 8], &[&tags(false, 1, 5)[..], &[(278, 5)]].concat(), &[(273, vec![8]), (279, vec![0])])
        }),
    ];
    for (name, word, bytes) in cases {
        let o = &read_all(&good, &[bytes])[0];
        refused(o, &good, name);
        assert!(o.message.contains(word), "{name}: {}", o.message);
    }
    // Right, if odd: a pixel a strip, a pixel a tile, thousands of decoders were they begun at once.
    let n = 8000;
    let list = |tags: [u16; 2]| [(tags[0], offsets(n)), (tags[1], vec![count; n as usize])];
    let strips = tiff(&many(n, &zeros), &[&tags(true, 1, n)[..], &[(278, 1)]].concat(), &list([273, 279]));
    let tiles = tiff(&many(n, &zeros), &[&tags(true, n, 1)[..], &[(322, 1), (323, 1)]].concat(), &list([324, 325]));
    let outcomes = read_all(&good, &[strips, tiles]);
    let pixels = outcomes.iter().map(|o| {
        let picture = o.picture.as_ref().unwrap_or_else(|| panic!("{}", o.message));
        split(picture).2.to_vec()
    });
    assert!(pixels.collect::<Vec<_>>() == vec![vec![0; 12 * n as usize]; 2]);
}

/// Tiles of which the picture has a part, side by side at once and row by row, and a strip taller than a block: deflated by zlib elsewhere,
/// each whole. tests/bad has them with a word more, and with another sum.
#[test]
fn padding_of_tiles_is_no_damage() {
    for name in ["tile_once", "tile_band", "tall"] {
        let bytes = std::fs::read(data_path(&format!("pixarlog_{name}.tif"))).unwrap();
        let out = stdout_of("ra_pixlog", &["-r", "--quiet"], &bytes);
        let values = floats(split(&out).2);
        // Codes 100, 200 and 300 at the left, and so many more of 1, 2 and 1 each pixel.
        assert!(values.len() > 500 && values[0] < values[1] && values[1] < values[2], "{name}");
        let rising = values.chunks(3).take(16).map(|p| p[0]).collect::<Vec<_>>();
        assert!(rising.is_sorted() && rising[0] < rising[15], "{name}: {rising:?}");
    }
}
