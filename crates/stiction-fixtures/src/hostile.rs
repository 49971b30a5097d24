//! Titles and names that would be markup, scripts, commands of a terminal or another reading direction: neither the report
//! nor a message lets them.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

use crate::folder::Folder;
use crate::fuzz::Random;

/// Pieces of hostile words. A script that runs gives the body an attribute, an element that is made
/// is one more: the structure tells both.
const PIECES: [&str; 24] = [
    "<script>document.body.id='owned'</script>",
    "<img src=x onerror=\"document.body.id='owned'\">",
    "\"><svg onload=document.body.id='owned'>",
    "' onmouseover='document.body.id=\"owned\"",
    "</title><h1>owned</h1>",
    "</pre></td></table><b>",
    "</script><script>document.body.id='owned'</script>",
    "<!--",
    "-->",
    "]]>",
    "&lt;b&gt; &amp; &#60;i&#62; & &copy",
    "javascript:document.body.id='owned'",
    "{{constructor.constructor('document.body.id=1')()}}",
    "\u{1b}[2J\u{1b}[31m",
    "\u{9b}2J",
    "\u{202e}desrever\u{2066}",
    "\u{200f}\u{61c}",
    "\u{7}\u{8}\u{7f}",
    "\r\nerror: no error",
    "\u{0}",
    "'; \"$(touch owned)\" `touch owned` \\",
    "\u{feff}\u{fffe}\u{e000}",
    "%s%n%x",
    "ü漢🦀",
];

/// What came of a campaign.
#[derive(Debug, Default)]
pub struct Report {
    pub cases: usize,
    /// Cases that were solved, whose report was looked at.
    pub solved: usize,
    /// Reports that a browser has opened.
    pub browsed: usize,
    /// What did not hold.
    pub findings: Vec<String>,
}

/// Reports that a browser opens one after the other: its start takes longer than all of them.
const PAGES: usize = 100;

/// Solves `count` cases by `command` and looks at messages and reports, in `browser` if there is one.
pub fn campaign(command: &Path, browser: Option<&Path>, seed: u64, count: usize) -> Report {
    let folder = Folder::new("hostile");
    let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
    let mut report = Report::default();
    let benign = ["title", "units", "steel", "half", "bottom", "part"].map(String::from);
    let wanted = solve(&folder, command, &benign).unwrap_or_else(|finding| panic!("{finding}"));
    let wanted = wanted.expect("a case of plain names is solved");
    let mut pages = Vec::new();
    while report.cases < count {
        report.cases += 1;
        let mut names = benign.clone();
        for _ in 0..=random.below(3) {
            let at = random.below(names.len());
            names[at] = (0..=random.below(4)).map(|_| PIECES[random.below(PIECES.len())]).collect();
            if random.below(20) == 0 {
                names[at] = names[at].repeat(1 + random.below(200));
            }
        }
        let word = &names[random.below(names.len())];
        report.findings.extend(refused(&folder, command, word).map(|finding| format!("argument {word:?}: {finding}")));
        let html = match solve(&folder, command, &names) {
            Ok(Some(html)) => html,
            Ok(None) => continue,
            Err(finding) => {
                report.findings.push(format!("{names:?}: {finding}"));
                continue;
            }
        };
        report.solved += 1;
        let mut seen = vec![("report.html", structure(&html) == structure(&wanted))];
        // Data of the script are strings of JSON, which is shown as text.
        let markup = html.split_once("<script").map_or(&html[..], |(markup, _)| markup);
        seen.push(("the text of the report", !markup.chars().any(commands)));
        seen.push(("the folder", !folder.exists("owned")));
        let wrong = seen.iter().filter(|(_, right)| !right);
        report.findings.extend(wrong.map(|(what, _)| format!("{names:?}: {what} is not as with plain names")));
        pages.push((names, html));
        if pages.len() == PAGES || report.cases == count {
            report.browse(&folder, browser, &wanted, &mut pages);
        }
    }
    report.browse(&folder, browser, &wanted, &mut pages);
    report
}

impl Report {
    /// Opens all pages in the browser.
    fn browse(
        &mut self,
        folder: &Folder,
        browser: Option<&Path>,
        wanted: &str,
        pages: &mut Vec<([String; 6], String)>,
    ) {
        let pages = std::mem::take(pages);
        let Some(browser) = browser.filter(|_| !pages.is_empty()) else { return };
        // The last page is open to what the others are closed to: the browser has to see it.
        let (head, body) = wanted.split_once("<h1").expect("a report has a heading");
        let open = format!("{head}{}<h1{body}", PIECES[0]);
        let html = pages.iter().map(|(_, html)| html).chain([&open]);
        let same = browse(folder, browser, std::iter::once(wanted).chain(html.map(|html| &html[..])));
        let [same @ .., false] = &same[..] else { panic!("the browser does not see a script that runs") };
        self.browsed += same.len();
        let wrong = pages.iter().zip(same).filter(|(_, same)| !**same);
        let wrong =
            wrong.map(|((names, _), _)| format!("{names:?}: the page in the browser is not as with plain names"));
        self.findings.extend(wrong);
    }
}

/// What is wrong with the messages about an argument that is none.
fn refused(folder: &Folder, command: &Path, word: &str) -> Option<String> {
    let word: String = word.chars().filter(|&c| c != '\0').take(1000).collect();
    let option = format!("--{word}");
    let calls = [vec![&word[..]], vec!["solve", "--threads", &word], vec!["check", &option]];
    calls.into_iter().find_map(|arguments| {
        let output =
            Command::new(command).args(arguments).current_dir(&folder.path).output().expect("the command runs");
        let text = String::from_utf8_lossy(&output.stderr);
        let found = text.chars().find(|&c| commands(c)).map(|c| format!("standard error has {c:?}: {text:?}"));
        let code = output.status.code().filter(|code| *code != 2).map(|code| format!("the command ends with {code}"));
        found.or(code)
    })
}

/// Solves a case with these names of title, units, material, step, group and file. The report, if it is solved; an error
/// if messages are not as they have to be.
fn solve(folder: &Folder, command: &Path, names: &[String; 6]) -> Result<Option<String>, String> {
    let [title, units, material, step, group, file] = names;
    // A file has a name of at most 255 bytes without slash and NUL.
    let file: String = file.chars().filter(|c| !matches!(c, '/' | '\0')).take(50).collect();
    let (mesh, case) = (format!("{file}.msh"), format!("{file}.toml"));
    folder.write(&mesh, cube(group));
    let text = format!(
        "title = {}\nunits = {}\n[mesh]\nfile = {}\n[materials.{}]\nyoung = 1000\npoisson = 0.3\n[[fix]]\non = \"top\"\n\
         value = [0, 0, -0.01]\n[[contact]]\non = {}\nagainst = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}\n\
         friction = {{ coulomb = 0.3 }}\n[[step]]\nname = {}\nuntil = 1\n",
        quoted(title),
        quoted(units),
        quoted(&mesh),
        quoted(material),
        quoted(group),
        quoted(step)
    );
    folder.write(&case, text);
    let _ = fs::remove_dir_all(folder.at("r"));
    let mut solve = Command::new(command);
    // After two dashes no name is an option.
    let arguments = ["solve", "-o", "r", "--threads", "1", "--progress", "plain", "--", &case];
    let output = solve.args(arguments).current_dir(&folder.path).output().expect("the command runs");
    let _ = fs::remove_file(folder.at(&mesh));
    let _ = fs::remove_file(folder.at(&case));
    for (stream, bytes) in [("output", &output.stdout), ("error", &output.stderr)] {
        let text = std::str::from_utf8(bytes).map_err(|_| format!("standard {stream} is no text"))?;
        if let Some(c) = text.chars().find(|&c| commands(c)) {
            return Err(format!("standard {stream} has {c:?}: {text:?}"));
        }
    }
    match output.status.code() {
        Some(0) => Ok(Some(fs::read_to_string(folder.at("r/report.html")).map_err(|e| e.to_string())?)),
        Some(2) => Ok(None),
        code => Err(format!("the command ends with {code:?}: {}", String::from_utf8_lossy(&output.stderr))),
    }
}

/// What a terminal obeys, and what turns the direction of text.
fn commands(c: char) -> bool {
    c.is_control() && !"\n\t".contains(c) || "\u{61c}\u{200e}\u{200f}".contains(c) || turns(c)
}

fn turns(c: char) -> bool {
    ('\u{202a}'..='\u{202e}').contains(&c) || ('\u{2066}'..='\u{2069}').contains(&c)
}

/// A string of TOML.
fn quoted(text: &str) -> String {
    let escaped = text.chars().map(|c| match c {
        'a'..='z' | 'A'..='Z' | '0'..='9' | ' ' => c.to_string(),
        c => format!("\\U{:08x}", u32::from(c)),
    });
    format!("\"{}\"", escaped.collect::<String>())
}

/// A cube whose lower face is called `bottom`, as far as a name of Gmsh can be.
fn cube(bottom: &str) -> String {
    let bottom: String = bottom.chars().filter(|c| !"\"\r\n".contains(*c)).collect();
    format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n2 1 \"{bottom}\"\n2 2 \"top\"\n3 3 \"body\"\n\
         $EndPhysicalNames\n$Nodes\n8\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 0 0 1\n6 1 0 1\n7 1 1 1\n8 0 1 1\n$EndNodes\n\
         $Elements\n3\n1 3 2 1 1 1 2 3 4\n2 3 2 2 2 5 6 7 8\n3 5 2 3 3 1 2 3 4 5 6 7 8\n$EndElements\n"
    )
}

/// Which pages have, after their scripts have run, the elements of the first one.
fn browse<'a>(folder: &Folder, browser: &Path, pages: impl Iterator<Item = &'a str>) -> Vec<bool> {
    let _ = fs::remove_dir_all(folder.at("pages"));
    fs::create_dir(folder.at("pages")).expect("a new folder");
    let count = pages.enumerate().map(|(k, html)| folder.write(&format!("pages/{k}.html"), html)).count() - 1;
    let judge = folder.write("pages/judge.html", include_str!("hostile.html").replace("COUNT", &count.to_string()));
    let mut child = Command::new(browser)
        .args(["--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--use-angle=swiftshader"])
        .args(["--enable-unsafe-swiftshader", "--ignore-gpu-blocklist", "--no-first-run", "--window-size=1200,1400"])
        .args(["--enable-logging=stderr", "--allow-file-access-from-files"])
        .arg(format!("--user-data-dir={}", folder.at("profile").display()))
        .arg(format!("file://{}", judge.display()))
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap_or_else(|e| panic!("{}: {e}", browser.display()));
    // The page tells what it has found on the console.
    let told = BufReader::new(child.stderr.take().expect("a pipe")).lines().map_while(Result::ok);
    let found = told.filter_map(|line| Some(line.split_once("JUDGED ")?.1.split_once(" END")?.0.to_string())).next();
    let _ = child.kill();
    let _ = child.wait();
    let found = found.unwrap_or_else(|| panic!("{} has not opened the pages", browser.display()));
    let same: Vec<bool> = found.split(' ').map(|word| word == "same").collect();
    assert_eq!(same.len(), count, "{found}");
    same
}

/// Elements of a page with the names of their attributes, in order.
fn structure(html: &str) -> Vec<String> {
    let (mut found, mut rest) = (Vec::new(), html);
    while let Some((_, after)) = rest.split_once('<') {
        // To the end of the tag, which no quoted value holds.
        let mut quote = None;
        let end = after.find(|c: char| {
            match quote {
                Some(open) if c == open => quote = None,
                None if "\"'".contains(c) => quote = Some(c),
                _ => {}
            }
            quote.is_none() && c == '>'
        });
        let (tag, after) = after.split_at(end.unwrap_or(after.len()));
        // Every second part stands in quotes.
        let names: String = tag.split('"').step_by(2).collect::<Vec<&str>>().join(" ");
        rest = after;
        for raw in ["script", "style"] {
            if tag.split_ascii_whitespace().next() == Some(raw) {
                rest = rest.find(&format!("</{raw}")).map_or("", |at| &rest[at..]);
            }
        }
        found.push(names);
    }
    found
}
