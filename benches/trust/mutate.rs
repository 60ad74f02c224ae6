//! Damage to files, by lot from a seed: what transfers, disks, editors and attackers do.

use crate::guard::Guard;
use crate::run::Random;

/// One damage.
pub struct Damage {
    /// What was done, for messages.
    pub what: String,
    /// Can every reader see it (see [`crate::guard`])?
    pub visible: bool,
}

/// Numbers that programs stumble over.
const NUMBERS: [&str; 22] = [
    "0",
    "-1",
    "1",
    "2147483647",
    "2147483648",
    "4294967295",
    "4294967296",
    "18446744073709551616",
    "1e999",
    "-1e999",
    "1e38",
    "1e-320",
    "nan",
    "inf",
    "-inf",
    "0.5",
    "1e9",
    "100000000",
    "0x10",
    "1e",
    "--1",
    "99999999999999999999999999999999999",
];
/// The same in four bytes.
const WORDS: [u32; 9] =
    [0, 1, 0x7fff_ffff, 0x8000_0000, 0xffff_ffff, 0x7f80_0000, 0x7fc0_0000, 0x0001_0000, 0x00ff_ffff];

/// A damaged copy of a file.
pub fn damaged(bytes: &[u8], text: bool, guard: &Guard, random: &mut Random) -> (Vec<u8>, Damage) {
    let mut file = bytes.to_vec();
    let damage =
        if text && random.below(4) > 0 { of_text(&mut file, random) } else { of_bytes(&mut file, guard, random) };
    (file, damage)
}

/// A place: half of them near the beginning, where sizes and offsets are.
fn place(length: usize, random: &mut Random) -> usize {
    if random.below(2) == 0 { random.below(length) } else { random.below(length.min(400)) }
}

fn of_bytes(file: &mut Vec<u8>, guard: &Guard, random: &mut Random) -> Damage {
    let at = place(file.len(), random);
    let pixels = guard.holds(at);
    let (what, visible) = match random.below(10) {
        0 | 1 => {
            let bit = random.below(8);
            file.iter_mut().skip(at).take(1).for_each(|b| *b ^= 1 << bit);
            (format!("bit {bit} of byte {at} flipped"), pixels && guard.summed)
        }
        2 => {
            let (n, value) = (1 + random.below(8), [0, 0xff, 0x7f, 0x80, random.next() as u8][random.below(5)]);
            file.iter_mut().skip(at).take(n).for_each(|b| *b = value);
            (format!("{n} bytes from {at} set to {value}"), pixels && guard.summed)
        }
        3 | 4 => {
            file.truncate(at);
            (format!("cut at byte {at}"), pixels)
        }
        5 => {
            let n = 1 + random.below(200);
            (0..n).for_each(|_| file.push(random.next() as u8));
            (format!("{n} bytes more"), !guard.pixels.is_empty())
        }
        6 => {
            let new: Vec<u8> = (0..1 + random.below(16)).map(|_| random.next() as u8).collect();
            let n = new.len();
            file.splice(at..at, new);
            (format!("{n} bytes put in at {at}"), pixels)
        }
        7 => {
            let n = (1 + random.below(16)).min(file.len() - at);
            file.drain(at..at + n);
            (format!("{n} bytes from {at} taken out"), pixels && n > 0)
        }
        8 => {
            let n = (1 + random.below(64)).min(file.len() - at);
            let copy = file[at..at + n].to_vec();
            file.splice(at..at, copy);
            (format!("{n} bytes from {at} twice"), pixels && n > 0)
        }
        _ => {
            let word = WORDS[random.below(WORDS.len())];
            let order = if random.below(2) == 0 { word.to_le_bytes() } else { word.to_be_bytes() };
            file.iter_mut().skip(at).zip(order).for_each(|(b, w)| *b = w);
            if random.below(2) == 0 {
                number(file, 1500, random);
            }
            (format!("word {word:x} at {at}, perhaps a number of the header"), false)
        }
    };
    Damage { what, visible: visible && !guard.explains(file) }
}

/// Another number in place of one that stands in the first bytes.
fn number(file: &mut Vec<u8>, within: usize, random: &mut Random) {
    let end = file.len().min(within);
    let digit = |i: usize| file[i].is_ascii_digit();
    let starts: Vec<usize> = (0..end).filter(|i| digit(*i) && (*i == 0 || !digit(*i - 1))).collect();
    if starts.is_empty() {
        return;
    }
    let at = starts[random.below(starts.len())];
    let n = file[at..].iter().take_while(|b| b.is_ascii_digit() || **b == b'.').count();
    file.splice(at..at + n, NUMBERS[random.below(NUMBERS.len())].bytes());
}

fn of_text(file: &mut Vec<u8>, random: &mut Random) -> Damage {
    let lines: Vec<Vec<u8>> = file.split_inclusive(|b| *b == b'\n').map(<[u8]>::to_vec).collect();
    let line = random.below(lines.len());
    let at = random.below(file.len());
    let what = match random.below(14) {
        0..=3 => {
            (0..1 + random.below(2)).for_each(|_| number(file, usize::MAX, random));
            "other numbers".to_string()
        }
        4 => joined(file, lines, |all| all.insert(line, all[line].clone()), format!("line {} twice", line + 1)),
        5 => joined(file, lines, |all| drop(all.remove(line)), format!("line {} taken out", line + 1)),
        6 => {
            let other = random.below(lines.len());
            joined(file, lines, |all| all.swap(line, other), format!("lines {} and {} swapped", line + 1, other + 1))
        }
        7 => {
            let long = [b"x", b"9", b" ", b"["][random.below(4)].repeat(20_000);
            file.splice(at..at, long);
            format!("20000 characters more at {at}")
        }
        8 => {
            let (deep, n) = ([&b"["[..], b"{", b"{ a = ", b"(", b"[[", b"\""][random.below(6)], 1 + random.below(3000));
            let value = file.iter().skip(at).position(|b| *b == b'=').map_or(at, |n| at + n + 1);
            file.splice(value..value, deep.repeat(n));
            format!("{n} nested brackets at {value}")
        }
        9 => {
            let text = String::from_utf8_lossy(file).replace('\n', "\r\n");
            *file = text.into_bytes();
            "lines that end as Windows has them".to_string()
        }
        10 => {
            let odd = [&b"\0"[..], b"\xff\xfe", b"\x1b[31m", "\u{202e}".as_bytes(), b"\\", b"\"", b"'", b"#", b"\r"];
            file.splice(at..at, odd[random.below(odd.len())].to_vec());
            format!("an odd character at {at}")
        }
        11 => {
            let words: Vec<&[u8]> =
                file.split(|b| !b.is_ascii_alphanumeric() && *b != b'_').filter(|w| w.len() > 2).collect();
            let (from, to) = (random.below(words.len()), random.below(words.len()));
            let Some((old, new)) = words.get(from).zip(words.get(to)).map(|(a, b)| (a.to_vec(), b.to_vec())) else {
                return Damage { what: "nothing".into(), visible: false };
            };
            let at = file.windows(old.len()).position(|w| w == old).unwrap_or(0);
            file.splice(at..at + old.len(), new);
            "a word in another's place".to_string()
        }
        12 => {
            let copy = file.clone();
            file.extend(copy);
            "all of it twice".to_string()
        }
        _ => {
            file.truncate(at);
            format!("cut at byte {at}")
        }
    };
    Damage { what, visible: false }
}

/// Lines after a change, as a file again.
fn joined(file: &mut Vec<u8>, mut lines: Vec<Vec<u8>>, change: impl FnOnce(&mut Vec<Vec<u8>>), what: String) -> String {
    if lines.is_empty() {
        return what;
    }
    change(&mut lines);
    *file = lines.concat();
    what
}
