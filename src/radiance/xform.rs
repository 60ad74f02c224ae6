//! The arguments of Radiance's `xform`: transforms, arrays, and what else it does to what it passes on.
//!
//! | argument | does |
//! |---|---|
//! | `-t x y z` | moves |
//! | `-rx -ry -rz degrees` | turns about an axis |
//! | `-s factor` | scales |
//! | `-mx -my -mz` | mirrors |
//! | `-i n` | what follows, up to the next `-i`, is done n times |
//! | `-a n` | n copies, the i-th with `-i i`; several nest |
//! | `-f file` | a copy for each line of arguments |
//! | `-n name`, `-m modifier`, `-I` | first: names begin with it, surfaces get it, surfaces are turned inside out |
//! | `-e`, `-c` | nothing: commands are never run |

use std::path::Path;

use glam::{DAffine3, DVec3};

use crate::error::printable;

/// Most copies of one line.
const MOST_COPIES: usize = 1 << 18;
/// Most `-a` and `-f` within each other.
const MOST_ARRAYS: usize = 16;

/// A similarity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Points to points.
    pub affine: DAffine3,
    /// Lengths to lengths; above 0.
    pub scale: f64,
    /// Right hands become left ones.
    pub mirrored: bool,
}

impl Motion {
    /// Nothing moves.
    pub const NONE: Motion = Motion { affine: DAffine3::IDENTITY, scale: 1.0, mirrored: false };

    /// First this one, then another.
    pub fn then(&self, next: &Motion) -> Motion {
        Motion {
            affine: next.affine * self.affine,
            scale: self.scale * next.scale,
            mirrored: self.mirrored != next.mirrored,
        }
    }

    /// A point moved.
    pub fn point(&self, p: DVec3) -> DVec3 {
        self.affine.transform_point3(p)
    }

    /// A vector turned, mirrored and scaled.
    pub fn vector(&self, v: DVec3) -> DVec3 {
        self.affine.transform_vector3(v)
    }

    fn times(&self, n: usize) -> Motion {
        // By squares: -i may say any number.
        let (mut result, mut power, mut n) = (Motion::NONE, *self, n);
        while n > 0 {
            if n & 1 == 1 {
                result = result.then(&power);
            }
            power = power.then(&power);
            n >>= 1;
        }
        result
    }
}

/// One copy of what a file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Copy {
    /// Where it goes.
    pub motion: Motion,
    /// Names begin with it and a dot.
    pub prefix: Option<String>,
    /// In place of the modifiers of surfaces.
    pub modifier: Option<String>,
    /// Surfaces are turned inside out.
    pub inverted: bool,
}

/// Copies of files.
#[derive(Clone, Debug, PartialEq)]
pub struct Xform {
    /// At least one.
    pub copies: Vec<Copy>,
    /// At least one.
    pub files: Vec<String>,
}

impl Xform {
    /// From the words after `xform`. Files of `-f` are read by `open`. An error says what is wrong and what would be right.
    pub fn parse(words: &[String], open: &dyn Fn(&Path) -> Result<Vec<u8>, String>) -> Result<Xform, String> {
        let (mut copies, mut files) = (Vec::new(), Vec::new());
        expand(words.to_vec(), open, 0, &mut |list| {
            let (copy, rest) = one(&list)?;
            if copies.len() == MOST_COPIES {
                return Err(format!("more than {MOST_COPIES} copies"));
            }
            copies.push(copy);
            files = rest.to_vec();
            Ok(())
        })?;
        if files.is_empty() {
            return Err("names no file; expected one or more at the end".into());
        }
        Ok(Xform { copies, files })
    }
}

type Each<'a> = &'a mut dyn FnMut(Vec<String>) -> Result<(), String>;

/// Calls `each` with the words of every copy.
fn expand(
    words: Vec<String>,
    open: &dyn Fn(&Path) -> Result<Vec<u8>, String>,
    depth: usize,
    each: Each,
) -> Result<(), String> {
    if depth > MOST_ARRAYS {
        return Err(format!("more than {MOST_ARRAYS} arrays within each other"));
    }
    if let Some(at) = words.iter().position(|w| w == "-f") {
        let file = words.get(at + 1).ok_or("-f: expected a file")?;
        let text = String::from_utf8_lossy(&open(Path::new(file))?).into_owned();
        let lines =
            text.lines().map(|l| l.trim_start_matches('!').trim()).filter(|l| !l.is_empty() && !l.starts_with('#'));
        for (i, line) in lines.enumerate() {
            let line = line.strip_prefix("xform ").unwrap_or(line);
            let new = super::lex::shell_words(line).map_err(|c| format!("-f {file}: '{c}' is for a shell"))?;
            let mut list = [&words[..at], &new, &words[at + 2..]].concat();
            rename(&mut list, &format!("i{i}"), i);
            expand(list, open, depth + 1, each)?;
        }
        return Ok(());
    }
    if let Some(at) = words.iter().position(|w| w == "-a") {
        let n = words.get(at + 1).and_then(|w| w.parse::<usize>().ok()).filter(|n| (1..=MOST_COPIES).contains(n));
        let n = n.ok_or_else(|| format!("-a: expected a number of copies from 1 to {MOST_COPIES}"))?;
        for i in 0..n {
            let mut list = words.clone();
            list[at] = "-i".into();
            list[at + 1] = i.to_string();
            rename(&mut list, &format!("a{i}"), i);
            expand(list, open, depth + 1, each)?;
        }
        return Ok(());
    }
    each(words)
}

/// Tells copies apart: `-n name` becomes `-n name.i`, and `-n new` where there is none.
fn rename(words: &mut Vec<String>, new: &str, i: usize) {
    match words.iter().position(|w| w == "-n").filter(|at| at + 1 < words.len()) {
        Some(at) => words[at + 1] = format!("{}.{i}", words[at + 1]),
        None => {
            words.splice(0..0, ["-n".to_string(), new.to_string()]);
        }
    }
}

/// A copy without arrays, and the files.
fn one(words: &[String]) -> Result<(Copy, &[String]), String> {
    let mut copy = Copy { motion: Motion::NONE, prefix: None, modifier: None, inverted: false };
    let mut rest = words;
    loop {
        rest = match rest {
            [option, name, after @ ..] if option == "-n" => {
                copy.prefix = Some(copy.prefix.map_or(name.clone(), |p| format!("{p}.{name}")));
                after
            }
            [option, name, after @ ..] if option == "-m" => {
                copy.modifier.get_or_insert(name.clone());
                after
            }
            [option, after @ ..] if option == "-c" || option == "-e" => after,
            [option, after @ ..] if option == "-I" => {
                copy.inverted = !copy.inverted;
                after
            }
            _ => break,
        };
    }
    let (motion, rest) = motion(rest)?;
    copy.motion = motion;
    match rest.first().filter(|w| w.starts_with('-')) {
        Some(word) => Err(format!(
            "'{}' is no transform; expected -t, -rx, -ry, -rz, -s, -mx, -my, -mz or -i",
            printable(word.as_bytes())
        )),
        None => Ok((copy, rest)),
    }
}

/// The transforms at the beginning of `words`, and what follows them.
pub fn motion(words: &[String]) -> Result<(Motion, &[String]), String> {
    let (mut total, mut part, mut times) = (Motion::NONE, Motion::NONE, 1);
    let mut rest = words;
    while let Some((word, after)) = rest.split_first() {
        let number = |i: usize| -> Result<f64, String> {
            let x = after.get(i).and_then(|w| w.parse().ok()).filter(|x: &f64| x.is_finite());
            x.ok_or_else(|| format!("{word}: expected {}", if word == "-t" { "three numbers" } else { "a number" }))
        };
        let turn = |f: fn(f64) -> DAffine3| Ok::<_, String>((f(number(0)?.to_radians()), 1.0, 1));
        let mirror = |v: DVec3| (DAffine3::from_scale(v), -1.0, 0);
        let (affine, scale, used) = match word.as_str() {
            "-t" => (DAffine3::from_translation(DVec3::new(number(0)?, number(1)?, number(2)?)), 1.0, 3),
            "-rx" => turn(DAffine3::from_rotation_x)?,
            "-ry" => turn(DAffine3::from_rotation_y)?,
            "-rz" => turn(DAffine3::from_rotation_z)?,
            "-s" => match number(0)? {
                0.0 => return Err("-s: expected a factor other than 0".into()),
                factor => (DAffine3::from_scale(DVec3::splat(factor)), factor, 1),
            },
            "-mx" => mirror(DVec3::new(-1.0, 1.0, 1.0)),
            "-my" => mirror(DVec3::new(1.0, -1.0, 1.0)),
            "-mz" => mirror(DVec3::new(1.0, 1.0, -1.0)),
            "-i" => {
                let n = after.first().and_then(|w| w.parse::<usize>().ok());
                total = total.then(&part.times(times));
                (part, times) = (Motion::NONE, n.ok_or("-i: expected a whole number from 0")?);
                rest = &after[1..];
                continue;
            }
            _ => break,
        };
        part = part.then(&Motion { affine, scale: f64::abs(scale), mirrored: scale < 0.0 });
        rest = &after[used..];
    }
    let motion = total.then(&part.times(times));
    let fits = motion.affine.is_finite() && motion.scale > 0.0 && motion.scale.is_finite();
    if fits { Ok((motion, rest)) } else { Err("the transform leads beyond all numbers".into()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(line: &str) -> Result<Xform, String> {
        let words: Vec<String> = line.split_whitespace().map(String::from).collect();
        Xform::parse(&words, &|_| Ok(b"# two places\n-t 1 0 0\n-rz 90 -t 0 5 0\n".to_vec()))
    }

    fn to(line: &str, p: [f64; 3]) -> Vec<[f64; 3]> {
        let round = |x: f64| (x * 1e9).round() / 1e9 + 0.0;
        let copies = parse(line).unwrap().copies;
        copies.iter().map(|c| c.motion.point(DVec3::from(p)).to_array().map(round)).collect()
    }

    /// Points that `xform` of Radiance 6.0a prints for a sphere's centre.
    #[test]
    fn transforms_are_done_in_their_order() {
        assert_eq!(to("-t 1 0 0 -rz 90 a.rad", [1.0, 0.0, 0.0]), [[0.0, 2.0, 0.0]]);
        assert_eq!(to("-rz 90 -t 1 0 0 a.rad", [1.0, 0.0, 0.0]), [[1.0, 1.0, 0.0]]);
        assert_eq!(to("-rx 90 -ry 90 -s 2 a.rad", [0.0, 1.0, 0.0]), [[2.0, 0.0, 0.0]]);
        assert_eq!(to("-mx -t 0 0 3 a.rad", [1.0, 2.0, 0.0]), [[-1.0, 2.0, 3.0]]);
        assert_eq!(to("-i 3 -t 1 0 0 -i 1 -s 2 a.rad", [0.0; 3]), [[6.0, 0.0, 0.0]]);
        assert_eq!(to("-i 0 -t 1 0 0 a.rad", [0.0; 3]), [[0.0; 3]]);
    }

    #[test]
    fn arrays_nest() {
        let line = "-n box -a 2 -t 10 0 0 -a 3 -t 0 1 0 -i 1 -t .5 0 0 a.rad";
        let want =
            [[0.5, 0.0], [0.5, 1.0], [0.5, 2.0], [10.5, 0.0], [10.5, 1.0], [10.5, 2.0]].map(|[x, y]| [x, y, 0.0]);
        assert_eq!(to(line, [0.0; 3]), want);
        let copies = parse(line).unwrap().copies;
        assert_eq!(copies[5].prefix.as_deref(), Some("box.1.2"));
        assert_eq!(parse("-a 2 -t 1 0 0 a.rad").unwrap().copies[1].prefix.as_deref(), Some("a1"));
        assert_eq!(to("-f places -t 0 0 1 a.rad", [1.0, 0.0, 0.0]), [[2.0, 0.0, 1.0], [0.0, 6.0, 1.0]]);
    }

    #[test]
    fn hands_and_sizes_are_kept() {
        let m = |line: &str| parse(line).unwrap().copies[0].motion;
        assert!(m("-mx a").mirrored && !m("-mx -my a").mirrored && m("-s -2 a").mirrored && m("-s -2 a").scale == 2.0);
        assert!((m("-s .5 -s .5 -rx 30 a").scale - 0.25).abs() < 1e-15);
        let all = parse("-n a -m red -I -e -t 0 0 0 b.rad c.rad").unwrap();
        let copy = &all.copies[0];
        assert_eq!((copy.modifier.as_deref(), copy.inverted, all.files.len()), (Some("red"), true, 2));
    }

    #[test]
    fn wrong_arguments_are_said() {
        for (line, word) in [
            ("-t 1 0 a.rad", "three numbers"),
            ("-s 0 a.rad", "other than 0"),
            ("-q 1 a.rad", "'-q' is no transform"),
            ("-t 1 0 0", "no file"),
            ("-a 0 a.rad", "-a:"),
            ("-a 262144 -t 1 0 0 -a 2 -t 0 1 0 a.rad", "copies"),
            ("-i x a.rad", "-i:"),
            ("-i 2000 -s 1e9 a.rad", "beyond"),
        ] {
            let message = parse(line).unwrap_err();
            assert!(message.contains(word), "{line}: {message}");
        }
    }
}
