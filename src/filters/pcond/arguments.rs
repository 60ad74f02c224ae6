//! Radiance's command line: switches `-h -a -v -s -c -l -w -I` with `+`, `-` or nothing behind them, each turning on, off or
//! over what the words before it left; `-p` with eight numbers; values that begin with a dash.

use std::ffi::OsString;

use crate::{Result, usage};

/// The switches of `-h`, by letter and long option.
const HUMAN: [(u8, &str); 4] = [(b'a', "acuity"), (b'v', "veil"), (b's', "sensitivity"), (b'c', "mesopic")];
/// Letters with one value, which may begin with a dash.
const VALUES: [(&str, &str); 6] =
    [("-e", "exposure"), ("-u", "ldmax"), ("-d", "lddyn"), ("-f", "calibration"), ("-i", "fixated"), ("-x", "map")];

/// On, off or over.
fn turned(now: bool, sign: Option<&u8>) -> bool {
    match sign {
        Some(b'+') => true,
        Some(b'-') => false,
        _ => !now,
    }
}

/// Radiance's words as long options; all others pass.
///
/// ```
/// let words = |line: &str| luxpipe::filters::pcond_arguments(line.split(' ').map(Into::into).collect()).unwrap();
/// assert_eq!(words("pcond -h -v- -e -1 in.hdr"), ["pcond", "--exposure=-1", "in.hdr", "--human", "--veil=false"]);
/// assert_eq!(words("pcond -h+ -h- -s"), ["pcond", "--sensitivity=true"]);
/// ```
pub fn rewrite(args: Vec<OsString>) -> Result<Vec<OsString>> {
    let mut words = Vec::new();
    let (mut human, mut switches) = (false, [false; 4]);
    let (mut linear, mut centre, mut ready) = (false, false, false);
    let mut args = args.into_iter();
    words.extend(args.next());
    let mut any = false;
    while let Some(arg) = args.next() {
        let Some(text) = arg.to_str().filter(|t| t.starts_with('-')) else {
            words.push(arg);
            continue;
        };
        if text == "--" {
            words.push(arg);
            words.extend(args);
            break;
        }
        if let Some((_, long)) = VALUES.iter().find(|v| v.0 == text) {
            let Some(value) = args.next() else { return usage!("{text} needs a value") };
            let mut word = OsString::from(format!("--{long}="));
            word.push(value);
            words.push(word);
            continue;
        }
        if text == "-p" {
            words.push(format!("--to={}", eight(&mut args)?).into());
            continue;
        }
        if text == "-m" {
            return usage!(
                "-m: colour warps are not read; describe the display instead: --display FILE (see pdisplay)"
            );
        }
        match text.as_bytes() {
            [b'-', letter, sign @ ..] if sign.is_empty() || sign == b"+" || sign == b"-" => {
                let sign = sign.first();
                let switch = HUMAN.iter().position(|s| s.0 == *letter);
                match (*letter, switch) {
                    (b'h', _) => {
                        switches = switches.map(|s| turned(s, sign));
                        human = turned(human, sign);
                    }
                    (_, Some(i)) => switches[i] = turned(switches[i], sign),
                    (b'l', _) => linear = turned(linear, sign),
                    (b'w', _) => centre = turned(centre, sign),
                    (b'I', _) => ready = turned(ready, sign),
                    _ => {
                        words.push(arg);
                        continue;
                    }
                }
                any = true;
            }
            _ => words.push(arg),
        }
    }
    // Before a `--` or a positional the order does not matter: at the end of the options.
    let mut tail: Vec<OsString> = Vec::new();
    if any {
        tail.extend(human.then(|| "--human".into()));
        let differ = HUMAN.iter().zip(switches).filter(|(_, on)| *on != human);
        tail.extend(differ.map(|((_, long), on)| format!("--{long}={on}").into()));
        tail.extend(linear.then(|| "--linear".into()));
        tail.extend(centre.then(|| "--centre".into()));
        tail.extend(ready.then(|| "--histogram=-".into()));
    }
    let at = words.iter().position(|w| w == "--").unwrap_or(words.len());
    words.splice(at..at, tail);
    Ok(words)
}

/// Eight numbers, as eight words or as one.
fn eight(args: &mut impl Iterator<Item = OsString>) -> Result<String> {
    let mut list: Vec<String> = Vec::new();
    while list.len() < 8 {
        let Some(word) = args.next() else {
            return usage!("-p needs eight numbers: x y of red, green, blue and white");
        };
        list.extend(word.to_string_lossy().split([',', ' ']).filter(|w| !w.is_empty()).map(String::from));
    }
    Ok(list.join(","))
}
