//! Letters of points: `font.txt`, read once.

use std::collections::BTreeMap;
use std::sync::OnceLock;

/// Points across a letter.
pub const WIDTH: usize = 5;
/// Points from one letter to the next.
pub const ADVANCE: usize = 6;
/// Points down a letter, what hangs below the line included.
pub const HEIGHT: usize = 8;
/// Points down a capital.
pub const CAPITAL: usize = 7;

/// A letter's rows, the leftmost point in bit 4.
pub type Glyph = [u8; HEIGHT];

/// The letter; a question mark for those that there are none of, nothing for a space.
///
/// ```
/// use luxpipe::chart::font::glyph;
/// assert_eq!(glyph('1')[..3], [0b00100, 0b01100, 0b00100]);
/// assert_eq!((glyph('€'), glyph(' ')), (glyph('?'), [0; 8]));
/// ```
pub fn glyph(c: char) -> Glyph {
    static ALL: OnceLock<BTreeMap<char, Glyph>> = OnceLock::new();
    let all = ALL.get_or_init(|| read(include_str!("font.txt")));
    if c == ' ' { [0; HEIGHT] } else { *all.get(&c).or_else(|| all.get(&'?')).unwrap_or(&[0; HEIGHT]) }
}

fn read(text: &str) -> BTreeMap<char, Glyph> {
    let mut all = BTreeMap::new();
    let lines: Vec<&str> = text.lines().skip(1).collect();
    for block in lines.chunks(HEIGHT + 1) {
        let names = block[0].strip_prefix("= ").unwrap_or("");
        for (i, name) in names.chars().enumerate() {
            let row = |line: &&str| {
                let points = line.split(' ').nth(i).unwrap_or("");
                points.bytes().fold(0, |bits, b| 2 * bits + u8::from(b == b'#'))
            };
            let rows: Vec<u8> = block[1..].iter().map(row).collect();
            all.insert(name, rows.try_into().unwrap_or_default());
        }
    }
    all
}
