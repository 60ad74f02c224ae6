//! The paper's sections in order with our figures and numbers beside its claims, as one page of HTML that opens from disk.
//!
//! `make paper` calls it as `paper_page out/paper`, from the folder that has docs/ and examples/. It reads page.md, which is Markdown with
//! directives, each alone on a line:
//!
//! - `{{page FILE}}`: a Markdown file without its title, its headings two levels deeper.
//! - `{{section FILE "Heading"}}`: one section of it.
//! - `{{svg FILE "caption"}}`: a drawing; without a slash in its name one of the output folder. The caption may be left out.
//! - `{{figure FILE "caption"}}`: a PNG, likewise.
//! - `{{claims Section}}`: the rows of docs/claims.csv that have this section; each section belongs on the page once.
//! - `{{verdicts}}`: how many claims have which verdict.

use std::fmt::Write as _;
use std::path::{Component, Path, PathBuf};

use pulldown_cmark::{CowStr, Event, HeadingLevel, Options, Parser, Tag, TagEnd, html};

/// A value, or one line that names the file and what is wrong.
pub type Answer<T> = Result<T, String>;

const SOURCE: &str = "examples/paper_page/page.md";
const CLAIMS: &str = "docs/claims.csv";
const TITLE: &str = "High Dynamic Range Imaging, measured";
/// How much deeper headings of other files are here.
const DEEPER: usize = 2;

const STYLE: &str = "\
:root { color-scheme: light dark; --edge: #8886; --paper: #fff; --ink: #1c1c1c; --link: #0b57a4; --code: #8881 }
@media (prefers-color-scheme: dark) { :root { --paper: #16181c; --ink: #e4e4e4; --link: #8ab8ff; --code: #8883 } }
* { box-sizing: border-box }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 46rem; margin: 0 auto; padding: 0 1rem 4rem; color: var(--ink);
  background: var(--paper); overflow-wrap: break-word }
a { color: var(--link) }
h1 { font-size: 1.7rem; line-height: 1.2 }
h2 { margin-top: 3rem; border-top: 1px solid var(--edge); padding-top: 1rem }
h3 { margin-top: 2rem } h4, h5, h6 { margin: 1.5rem 0 .5rem }
nav { border-block: 1px solid var(--edge); padding: .5rem 0 } nav a { display: inline-block; margin-right: .9rem }
code { background: var(--code); padding: .05em .25em; border-radius: .2em; font-size: .9em }
pre { overflow-x: auto; background: var(--code); padding: .6rem .8rem; border-radius: .3em } pre code { background: none; padding: 0 }
figure { margin: 1.5rem 0 } figcaption { font-size: .9rem; padding: .3rem 0 }
img { max-width: 100%; height: auto; display: block }
.chart, .wide { display: block; overflow-x: auto }
.chart svg { display: block; width: 100%; min-width: 30rem; height: auto; background: #fff }
table { border-collapse: collapse; font-size: .85rem; margin: .5rem 0 1rem }
th, td { text-align: left; vertical-align: top; padding: .2rem .6rem; border-bottom: 1px solid var(--edge) }
.claims td { min-width: 5rem } .claims td:first-child { min-width: 15rem } .claims td:last-child { min-width: 9rem }
.verdict { display: inline-block; padding: 0 .5em; border-radius: .8em; color: #fff; white-space: nowrap }
.yes { background: #1b7036 } .no { background: #b3261e } .nearly { background: #56690f } .partly { background: #8a4b00 } .open { background: #5b6068 }
details { border: 1px solid var(--edge); border-radius: .3em; padding: .4rem .8rem; margin: 1rem 0 } summary { cursor: pointer }
";

/// A row of docs/claims.csv.
struct Claim {
    section: String,
    claim: String,
    paper: String,
    ours: String,
    unit: String,
    verdict: String,
    command: String,
}

/// What of a Markdown file is wanted.
enum Part<'a> {
    WithoutTitle,
    Section(&'a str),
}

/// The page as far as it has come.
struct Page<'a> {
    /// Folder that it is written to.
    out: &'a Path,
    /// From there to the folder that the program runs in, a slash at its end.
    root: String,
    claims: Vec<Claim>,
    /// Sections of the claims that are on it.
    claimed: Vec<String>,
    /// Its own headings: level, id, words.
    headings: Vec<(HeadingLevel, String, String)>,
    /// Links to its own headings.
    within: Vec<String>,
}

/// Reads page.md and all that it asks for; writes index.html, whole or not at all.
pub fn run(out: &Path) -> Answer<()> {
    let mut page = Page {
        out,
        root: way_back(out)?,
        claims: claims(&read(CLAIMS)?)?,
        claimed: Vec::new(),
        headings: Vec::new(),
        within: Vec::new(),
    };
    let body = page.body(&read(SOURCE)?)?;
    page.check()?;
    let (part, whole) = (out.join("index.html.part"), out.join("index.html"));
    let written = std::fs::write(&part, page.document(&body)).and_then(|()| std::fs::rename(&part, &whole));
    written.map_err(|e| format!("{}: {e}", whole.display()))
}

fn read(name: &str) -> Answer<String> {
    std::fs::read_to_string(name).map_err(|e| format!("{name}: {e}"))
}

/// What leads from pages in a folder to the folder that the program runs in.
fn way_back(out: &Path) -> Answer<String> {
    let real = |p: &Path| p.canonicalize().map_err(|e| format!("{}: {e}", p.display()));
    let here = real(Path::new("."))?;
    Ok(match real(out)?.strip_prefix(&here) {
        Ok(rest) => "../".repeat(rest.components().count()),
        Err(_) => format!("{}/", here.display()),
    })
}

impl Page<'_> {
    /// The Markdown of page.md as HTML, its directives replaced.
    fn body(&mut self, text: &str) -> Answer<String> {
        let (mut body, mut markdown, mut in_code) = (String::new(), String::new(), false);
        for (number, line) in (1..).zip(text.lines()) {
            in_code ^= line.trim_start().starts_with("```");
            let directive = line.trim().strip_prefix("{{").and_then(|l| l.strip_suffix("}}"));
            let Some(directive) = directive.filter(|_| !in_code) else {
                markdown += line;
                markdown.push('\n');
                continue;
            };
            body += &self.own(&std::mem::take(&mut markdown))?;
            body += &self.directive(directive.trim()).map_err(|e| format!("{SOURCE}:{number}: {e}"))?;
        }
        body += &self.own(&markdown)?;
        Ok(body)
    }

    /// A stretch of page.md.
    fn own(&mut self, text: &str) -> Answer<String> {
        let mut events: Vec<Event> = parser(text).collect();
        for i in 0..events.len() {
            if !matches!(events.get(i), Some(Event::Start(Tag::Heading { .. }))) {
                continue;
            }
            let words = words(events.get(i + 1..).unwrap_or_default());
            if let Some(Event::Start(Tag::Heading { level, id, .. })) = events.get_mut(i) {
                let slug = slug(&words);
                *id = Some(slug.clone().into());
                self.headings.push((*level, slug, words));
            }
        }
        self.html(events, SOURCE, 0)
    }

    /// HTML in place of a directive.
    fn directive(&mut self, text: &str) -> Answer<String> {
        let (verb, rest) = text.split_once(' ').unwrap_or((text, ""));
        let (target, quoted) = match rest.split_once('"') {
            None => (rest.trim(), None),
            Some((target, tail)) => (target.trim(), Some(tail.strip_suffix('"').ok_or("a quotation has no end")?)),
        };
        match (verb, quoted) {
            (_, _) if target.is_empty() != (verb == "verdicts") => Err(unknown(text)),
            ("page", None) => self.markdown(target, &Part::WithoutTitle),
            ("section", Some(heading)) => self.markdown(target, &Part::Section(heading)),
            ("svg", caption) => {
                let svg = drawing(&self.place(target)?)?;
                self.figure("chart", &svg, caption)
            }
            ("figure", Some(caption)) => {
                let alt = caption.replace(['`', '*'], "");
                let png = picture(&self.place(target)?, &alt)?;
                self.figure("photo", &png, Some(caption))
            }
            ("claims", None) => self.claims(target),
            ("verdicts", None) => Ok(self.verdicts()),
            _ => Err(unknown(text)),
        }
    }

    /// Where a figure lies; of the output folder's an error that says what makes it where it is missing.
    fn place(&self, target: &str) -> Answer<PathBuf> {
        if target.contains('/') {
            return Ok(target.into());
        }
        let path = self.out.join(target);
        match target {
            _ if path.is_file() => Ok(path),
            _ if target.starts_with("figure") => {
                Err(format!("{}: no such file; make paper-tone makes it", path.display()))
            }
            _ => Err(format!("{}: no such file; make out/paper/{target} makes it", path.display())),
        }
    }

    /// What is drawn and the words below it, which may have Markdown.
    fn figure(&mut self, class: &str, what: &str, caption: Option<&str>) -> Answer<String> {
        let words = self.html(parser(caption.unwrap_or_default()).collect(), SOURCE, 0)?;
        let words = words.trim().trim_start_matches("<p>").trim_end_matches("</p>");
        let caption = if words.is_empty() { String::new() } else { format!("<figcaption>{words}</figcaption>") };
        Ok(format!("<figure><div class=\"{class}\">{what}</div>{caption}</figure>\n"))
    }

    /// A Markdown file or a section of it.
    fn markdown(&mut self, file: &str, part: &Part) -> Answer<String> {
        let text = read(file)?;
        let mut events: Vec<Event> = parser(&text).collect();
        let level = |e: &Event| match e {
            Event::Start(Tag::Heading { level, .. }) => Some(*level),
            _ => None,
        };
        match *part {
            Part::WithoutTitle => {
                let end = events.iter().position(|e| *e == Event::End(TagEnd::Heading(HeadingLevel::H1)));
                if let Some(end) = end.filter(|_| events.first().and_then(level) == Some(HeadingLevel::H1)) {
                    events.drain(..=end);
                }
            }
            Part::Section(heading) => {
                let is_it = |i: &usize| level(&events[*i]).is_some() && words(&events[i + 1..]) == heading;
                let missing = || format!("{file}: no section is called \"{heading}\"");
                let begin = (0..events.len()).find(is_it).ok_or_else(missing)?;
                let own = level(&events[begin]);
                let next = events[begin + 1..].iter().position(|e| level(e).is_some_and(|l| Some(l) <= own));
                events.truncate(next.map_or(events.len(), |n| begin + 1 + n));
                events.drain(..begin);
            }
        }
        self.html(events, file, DEEPER)
    }

    /// HTML of what `file` has, with links that work from the page, pictures within it and headings `deeper`.
    fn html(&mut self, events: Vec<Event>, file: &str, deeper: usize) -> Answer<String> {
        let lowered = |level: HeadingLevel| HeadingLevel::try_from(level as usize + deeper).unwrap_or(HeadingLevel::H6);
        let mut done: Vec<Event> = Vec::with_capacity(events.len());
        let mut rest = events.into_iter();
        while let Some(event) = rest.next() {
            match event {
                Event::Start(Tag::Heading { level, id, classes, attrs }) => {
                    done.push(Event::Start(Tag::Heading { level: lowered(level), id, classes, attrs }));
                }
                Event::End(TagEnd::Heading(level)) => done.push(Event::End(TagEnd::Heading(lowered(level)))),
                Event::Start(Tag::Table(_)) => done.extend([raw("<div class=\"wide\">"), event]),
                Event::End(TagEnd::Table) => done.extend([event, raw("</div>\n")]),
                Event::Start(Tag::Link { link_type, dest_url, title, id }) => {
                    let dest_url = self.link(file, &dest_url)?.into();
                    done.push(Event::Start(Tag::Link { link_type, dest_url, title, id }));
                }
                Event::Start(Tag::Image { dest_url, .. }) => {
                    let inner: Vec<Event> = rest.by_ref().take_while(|e| *e != Event::End(TagEnd::Image)).collect();
                    let path = beside(file, &dest_url);
                    let html = match path.extension().and_then(|e| e.to_str()) {
                        Some("svg") => format!("<span class=\"chart\">{}</span>", drawing(&path)?),
                        _ => picture(&path, &words(&inner))?,
                    };
                    done.push(Event::InlineHtml(html.into()));
                }
                event => done.push(event),
            }
        }
        let mut text = String::new();
        html::push_html(&mut text, done.into_iter());
        Ok(text)
    }

    /// A link of `file` as it must read on the page.
    fn link(&mut self, file: &str, url: &str) -> Answer<String> {
        if url.contains("://") || url.starts_with("mailto:") {
            return Ok(url.into());
        }
        let (target, fragment) = url.split_at(url.find('#').unwrap_or(url.len()));
        if target.is_empty() && file == SOURCE {
            self.within.push(fragment.trim_start_matches('#').into());
            return Ok(url.into());
        }
        let path = if target.is_empty() { PathBuf::from(file) } else { beside(file, target) };
        if !path.exists() {
            return Err(format!("{file}: its link to {url} leads nowhere"));
        }
        Ok(format!("{}{}{fragment}", self.root, path.display()))
    }

    /// The table of a section's claims.
    fn claims(&mut self, section: &str) -> Answer<String> {
        let mut table = String::from(
            "<div class=\"wide\"><table class=\"claims\">\n<thead><tr><th>The paper's claim</th><th>Paper</th><th>Ours</th>\
             <th>Verdict</th><th>Command</th></tr></thead>\n<tbody>\n",
        );
        let mut count = 0;
        for c in self.claims.iter().filter(|c| c.section == section) {
            let [claim, paper, ours, unit, command] =
                [&c.claim, &c.paper, &c.ours, &c.unit, &c.command].map(|t| escaped(t));
            // The unit is of both; once is enough.
            let (paper, ours) = match (ours.is_empty(), unit.is_empty()) {
                (_, true) => (paper, ours),
                (false, false) => (paper, format!("{ours} <small>{unit}</small>")),
                (true, false) => (format!("{paper} <small>{unit}</small>"), ours),
            };
            let command = if command.is_empty() { command } else { format!("<code>{command}</code>") };
            let verdict = badge(&c.verdict);
            let _ = writeln!(
                table,
                "<tr><td>{claim}</td><td>{paper}</td><td>{ours}</td><td>{verdict}</td><td>{command}</td></tr>"
            );
            count += 1;
        }
        if count == 0 {
            return Err(format!("{CLAIMS} has no claims of a section called \"{section}\""));
        }
        if self.claimed.iter().any(|c| c == section) {
            return Err(format!("the claims of \"{section}\" are on the page already"));
        }
        self.claimed.push(section.into());
        Ok(table + "</tbody></table></div>\n")
    }

    /// How many claims have which verdict, the most frequent first.
    fn verdicts(&self) -> String {
        let mut counts: Vec<(&str, usize)> = Vec::new();
        for claim in &self.claims {
            match counts.iter_mut().find(|c| c.0 == claim.verdict) {
                Some(own) => own.1 += 1,
                None => counts.push((&claim.verdict, 1)),
            }
        }
        counts.sort_by_key(|c| std::cmp::Reverse(c.1));
        let each: Vec<String> = counts.iter().map(|(verdict, n)| format!("{n} {}", badge(verdict))).collect();
        format!("<p>Claims on this page: {}, of them {}.</p>\n", self.claims.len(), each.join(", "))
    }

    /// That no claim is left out and no link within the page leads nowhere.
    fn check(&self) -> Answer<()> {
        if let Some(left) = self.claims.iter().find(|c| !self.claimed.contains(&c.section)) {
            return Err(format!("{SOURCE}: no line {{{{claims {}}}}}, a section of {CLAIMS}", left.section));
        }
        match self.within.iter().find(|w| !self.headings.iter().any(|h| h.1 == **w)) {
            Some(broken) => Err(format!("{SOURCE}: its link to #{broken} leads to no heading")),
            None => Ok(()),
        }
    }

    /// The whole file.
    fn document(&self, body: &str) -> String {
        let mut nav = String::from("<nav>\n");
        for (_, id, words) in self.headings.iter().filter(|h| h.0 == HeadingLevel::H2) {
            let _ = writeln!(nav, "<a href=\"#{id}\">{}</a>", escaped(words));
        }
        nav += "</nav>\n";
        let (before, after) = body.split_at(body.find("<h2").unwrap_or(body.len()));
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{TITLE}</title>\n\
             <style>\n{STYLE}</style>\n</head>\n<body>\n{before}{nav}{after}</body>\n</html>\n"
        )
    }
}

fn parser(text: &str) -> Parser<'_> {
    Parser::new_ext(text, Options::ENABLE_TABLES)
}

fn raw(html: &str) -> Event<'_> {
    Event::Html(CowStr::from(html))
}

/// Plain words up to the end of a heading, or of all there is.
fn words(events: &[Event]) -> String {
    let own = events.iter().take_while(|e| !matches!(e, Event::End(TagEnd::Heading(_))));
    own.filter_map(|e| match e {
        Event::Text(t) | Event::Code(t) => Some(t.as_ref()),
        Event::SoftBreak => Some(" "),
        _ => None,
    })
    .collect()
}

fn unknown(directive: &str) -> String {
    let known =
        "page FILE, section FILE \"Heading\", svg FILE \"caption\", figure FILE \"caption\", claims Section, verdicts";
    format!("{{{{{directive}}}}} is none of {known}")
}

/// Words as an id: letters and digits, hyphens between them.
fn slug(words: &str) -> String {
    let lower = words.to_lowercase();
    let parts: Vec<&str> = lower.split(|c: char| !c.is_alphanumeric()).filter(|p| !p.is_empty()).collect();
    parts.join("-")
}

/// The path that `url` means in `file`, without `..` where that can be.
fn beside(file: &str, url: &str) -> PathBuf {
    let mut path = PathBuf::new();
    for part in Path::new(file).parent().unwrap_or(Path::new("")).join(url).components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if path.file_name().is_some() => {
                path.pop();
            }
            part => path.push(part),
        }
    }
    path
}

/// An SVG file's element, for HTML.
fn drawing(path: &Path) -> Answer<String> {
    let text = std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
    let ends = text.find("<svg").zip(text.rfind("</svg>"));
    let svg = ends.and_then(|(begin, end)| text.get(begin..end));
    svg.map(|s| format!("{s}</svg>")).ok_or_else(|| format!("{}: not an SVG file", path.display()))
}

/// A PNG file as an element that holds it.
fn picture(path: &Path, alt: &str) -> Answer<String> {
    let bytes = std::fs::read(path).map_err(|e| format!("{}: {e}", path.display()))?;
    if !bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
        return Err(format!("{}: not a PNG file", path.display()));
    }
    Ok(format!("<img alt=\"{}\" src=\"data:image/png;base64,{}\">", escaped(alt), luxpipe::base64::encoded(&bytes)))
}

/// A verdict on its colour; it reads the same without.
fn badge(verdict: &str) -> String {
    let class = match verdict {
        "holds" => "yes",
        "holds-roughly" => "nearly",
        "differs" => "partly",
        "wrong" => "no",
        _ => "open",
    };
    format!("<span class=\"verdict {class}\">{}</span>", escaped(verdict))
}

/// The rows of docs/claims.csv.
fn claims(text: &str) -> Answer<Vec<Claim>> {
    let mut lines = (1..).zip(text.lines()).filter(|(_, l)| !l.starts_with('#') && !l.trim().is_empty());
    let named = |number: usize, why: &str| format!("{CLAIMS}:{number}: {why}");
    let (number, head) = lines.next().ok_or_else(|| format!("{CLAIMS}: no line of names"))?;
    let head = fields(head).map_err(|e| named(number, e))?;
    let column = |name: &str| {
        let found = head.iter().position(|h| h.trim() == name);
        found.ok_or_else(|| named(number, &format!("no column is called {name}")))
    };
    let columns = ["section", "claim", "paper", "ours", "unit", "verdict", "command"].map(column);
    let columns = columns.into_iter().collect::<Answer<Vec<usize>>>()?;
    let mut rows = Vec::new();
    for (number, line) in lines {
        let own = fields(line).map_err(|e| named(number, e))?;
        if own.len() != head.len() {
            return Err(named(number, &format!("{} fields in place of {}", own.len(), head.len())));
        }
        let mut cells = columns.iter().map(|c| own.get(*c).map(|cell| cell.trim().to_string()).unwrap_or_default());
        let mut next = || cells.next().unwrap_or_default();
        let (section, claim, paper, ours) = (next(), next(), next(), next());
        rows.push(Claim { section, claim, paper, ours, unit: next(), verdict: next(), command: next() });
    }
    Ok(rows)
}

/// The fields of a line of CSV; a quotation mark within quotation marks is written twice.
fn fields(line: &str) -> Result<Vec<String>, &'static str> {
    let (mut all, mut own, mut quoted) = (Vec::new(), String::new(), false);
    let mut chars = line.chars().peekable();
    while let Some(c) = chars.next() {
        match c {
            '"' if quoted && chars.peek() == Some(&'"') => own.extend(chars.next()),
            '"' => quoted = !quoted,
            ',' if !quoted => all.push(std::mem::take(&mut own)),
            c => own.push(c),
        }
    }
    all.push(own);
    if quoted { Err("a quotation has no end") } else { Ok(all) }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
