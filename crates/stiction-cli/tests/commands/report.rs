//! `report.html`: its structure, its numbers, and how it looks in a browser.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::folder::{CASE, Folder};
use serde_json::Value;
use stiction::io::vtu_read::{Over, read_body, read_polygons};

/// A title that would run if it were not escaped, in a case with steps, a pair of bodies and contact with friction.
const TITLE: &str = "<script>document.body.id='owned'</script> Größe \\\"µ\\\" & 'more'";

fn case() -> String {
    CASE.replace("title = \"Block\"", &format!("title = \"{TITLE}\"")).replace("(3 - x)\"", "(3 - x)*t\"")
        + "\n[[step]]\nname = \"<b>half</b>\"\nuntil = 0.5\n[[step]]\nuntil = 1\n# </pre><script>owned()</script>\n"
}

/// Names of elements without an end.
const VOID: [&str; 6] = ["meta", "img", "input", "br", "hr", "link"];

/// Checks that every element ends where it should, and returns the texts of the elements called `name`.
fn elements<'a>(html: &'a str, name: &str) -> Vec<&'a str> {
    let (mut open, mut found, mut rest): (Vec<(&str, usize)>, Vec<&str>, usize) = (Vec::new(), Vec::new(), 0);
    while let Some(at) = html[rest..].find('<').map(|i| rest + i) {
        // What stands in scripts and styles is no markup.
        if let Some((raw @ ("script" | "style"), _)) = open.last()
            && !html[at..].starts_with(&format!("</{raw}"))
        {
            rest = at + 1;
            continue;
        }
        let end = at + html[at..].find('>').expect("a tag ends");
        let tag = &html[at + 1..end];
        rest = end + 1;
        if tag.starts_with('!') || tag.ends_with('/') {
            continue;
        }
        if let Some(closing) = tag.strip_prefix('/') {
            let (opened, from) = open.pop().expect("an element ends that was begun");
            assert_eq!(opened, closing, "near {}", &html[at.saturating_sub(80)..end]);
            if opened == name {
                found.push(&html[from..at]);
            }
        } else {
            let called = tag.split_ascii_whitespace().next().unwrap();
            if !VOID.contains(&called) {
                open.push((called, rest));
            }
        }
    }
    assert!(open.is_empty(), "{open:?}");
    found
}

fn unescaped(text: &str) -> String {
    let pairs = [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&#39;", "'"), ("&amp;", "&")];
    pairs.iter().fold(text.to_string(), |text, (coded, plain)| text.replace(coded, plain))
}

/// RFC 4648, the other way round.
fn bytes(text: &str) -> Vec<u8> {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let value = |c: u8| LETTERS.iter().position(|&l| l == c).map_or(0, |v| v as u32);
    let mut out = Vec::new();
    for chunk in text.as_bytes().chunks(4) {
        let word = chunk.iter().fold(0, |word, &c| word << 6 | value(c));
        let padding = chunk.iter().filter(|&&c| c == b'=').count();
        out.extend(&word.to_be_bytes()[1..4 - padding]);
    }
    out
}

fn words(value: &Value) -> Vec<u16> {
    bytes(value.as_str().unwrap()).as_chunks().0.iter().map(|&b| u16::from_le_bytes(b)).collect()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// Numbers of a stored field: 65534 steps from the lowest to the highest, NaN where there is none.
fn decoded(field: &Value) -> Vec<f64> {
    let (low, high) = (number(&field["low"]), number(&field["high"]));
    let of = |&code: &u16| if code == u16::MAX { f64::NAN } else { low + f64::from(code) / 65534.0 * (high - low) };
    words(&field["data"]).iter().map(of).collect()
}

fn view(html: &str) -> Value {
    let data = elements(html, "script").into_iter().find(|text| text.starts_with('{')).unwrap();
    serde_json::from_str(data).unwrap()
}

fn solved(name: &str) -> (Folder, String) {
    let folder = Folder::new(name, &case());
    folder.run(&["solve", "case.toml", "-o", "r", "--progress", "none"]).ends(0, &[]);
    let html = std::fs::read_to_string(folder.path.join("r/report.html")).unwrap();
    (folder, html)
}

#[test]
fn the_report_is_whole_offline_and_nothing_of_the_case_becomes_markup() {
    let (folder, html) = solved("report-text");
    // Figures of the whole run: how small it is, and what friction has done.
    assert!(html.contains("<h2 id=\"small\">") && html.contains("<h2 id=\"fretting\">"));
    let title = elements(&html, "title");
    assert_eq!(unescaped(title[0]), TITLE.replace("\\\"", "\""));
    assert!(!html.contains("<script>document") && !html.contains("<script>owned") && !html.contains("<b>half"));
    assert_eq!(elements(&html, "script").len(), 2);
    // The case file word for word.
    assert_eq!(unescaped(elements(&html, "pre")[0]), case());
    // Nothing is fetched: the only sources are data, and no address appears at all.
    assert!(html.matches("src=").count() == html.matches("src=\"data:image/png;base64,").count());
    let markup = html.replace(&case(), "");
    for word in ["http:", "https:", "url(", "@import", "<link", "fetch(", "XMLHttpRequest"] {
        assert!(!markup.contains(word), "{word}");
    }
    // The verdict comes before everything else, every measure with its bound, and what a reader asks for.
    let verdict = html.find("Solved and certified").unwrap();
    assert!(verdict < html.find("id=\"viewer\"").unwrap());
    let summary = folder.summary("r");
    let certificate = summary["certificate"].as_object().unwrap();
    for (name, value) in certificate.iter().filter(|(name, value)| value.is_f64() && *name != "worst") {
        let (name, value) = (name.replace('_', " "), format!("{:.1e}", number(value)));
        assert!(
            name.ends_with("tolerance") || html.contains(&format!("<td>{name}</td><td>{value}</td>")),
            "{name} {value}"
        );
    }
    for word in ["stiction solve case.toml -o r", env!("CARGO_PKG_VERSION"), "young 2.119e11", "[Pa]", "(x, y, z) [N]"]
    {
        assert!(html.contains(word), "{word}");
    }
    let pictures = elements(&html, "figcaption");
    assert!(
        ["deformed.png", "error.png", "pressure.png", "shear.png", "status.png", "convergence.png", "history.png"]
            .iter()
            .all(|name| pictures.contains(name))
    );
    // From the files alone the same report comes out.
    std::fs::remove_file(folder.path.join("r/report.html")).unwrap();
    folder.run(&["report", "r"]).ends(0, &[]);
    assert!(html == std::fs::read_to_string(folder.path.join("r/report.html")).unwrap(), "another report");
    // And none where none is wanted, not even an old one.
    folder.run(&["solve", "case.toml", "-o", "r", "--progress", "none", "--no-report"]).ends(0, &[]);
    assert!(!folder.exists("r/report.html") && folder.exists("r/summary.json"));
    folder.run(&["report", "."]).ends(2, &["summary.json"]);
}

#[test]
fn the_arrays_of_the_view_are_the_numbers_of_the_result_files() {
    let (folder, html) = solved("report-arrays");
    let view = view(&html);
    let (n, first) = (view["points"].as_u64().unwrap() as usize, view["firstContactPoint"].as_u64().unwrap() as usize);
    assert_eq!(view["frames"].as_array().unwrap().len(), 2);
    let axis = |c: usize| (number(&view["low"][c]), number(&view["high"][c]));
    assert_eq!([axis(0), axis(1), axis(2)], [(0.0, 3.0), (0.0, 1.0), (0.0, 1.0)]);
    let place: Vec<f64> = (words(&view["position"]).iter().enumerate())
        .map(|(i, &code)| axis(i % 3).0 + f64::from(code) / 65534.0 * (axis(i % 3).1 - axis(i % 3).0))
        .collect();
    assert_eq!(place.len(), 3 * n);
    // The boundary of 9 x 3 x 3 hexahedra: 126 quadrilaterals, 27 of them the contact surface with its 40 nodes.
    assert_eq!((words(&view["faces"]).len(), view["firstContactFace"].as_u64()), (4 * 126, Some(99)));
    assert_eq!(n - first, 40);
    for (number_, frame) in (1..).zip(view["frames"].as_array().unwrap()) {
        let file = |front: &str| folder.path.join(format!("r/{front}-{number_:04}.vtu"));
        let (mesh, body) = read_body(&file("result"), &[(Over::Points, "displacement")]).unwrap();
        let u = body.arrays[0].as_ref().unwrap();
        let largest = number(&frame["largest"]);
        assert_eq!(largest, u.iter().fold(0.0, |a: f64, u| a.max(u.abs())));
        let codes = words(&frame["displacement"]);
        for v in 0..n {
            let at = |x: &[f64; 3]| (0..3).all(|c| (x[c] - place[3 * v + c]).abs() < 1e-4);
            let node = mesh.nodes.iter().position(at).unwrap();
            for c in 0..3 {
                let shown = f64::from(codes[3 * v + c] as i16) / 32767.0 * largest;
                assert!((shown - u[3 * node + c]).abs() <= 0.51 / 32767.0 * largest);
            }
        }
        let names = [(Over::Points, "pressure"), (Over::Points, "status")];
        let (_, contact) = read_polygons(&file("contact"), &names).unwrap();
        for (field, stored) in [1, 5].into_iter().zip(&contact.arrays) {
            let (shown, stored) = (decoded(&frame["values"][field]), stored.as_ref().unwrap());
            let most = stored.iter().fold(0.0, |a: f64, v| a.max(v.abs()));
            assert!(shown[..first].iter().all(|v| v.is_nan()), "the body has no contact values");
            let same = |(a, b): (&f64, &f64)| a.is_nan() && b.is_nan() || (a - b).abs() <= 0.51 / 65534.0 * most;
            assert!(shown[first..].iter().zip(stored).all(same));
        }
    }
    assert_eq!(view["fields"][1]["label"], "Contact pressure");
    assert_eq!(view["fields"][5]["status"], true);
}

/// A column of tetrahedra and one of hexahedra, each under its own traction: files have the kinds of cells in another order than the mesh
/// has, and stress stands at the cells it is of, in all load steps, whether the page is made with the mesh at hand or from files.
#[test]
fn stress_stands_at_its_own_cells_where_there_are_several_kinds() {
    for (left, right) in [("tet4", "hex8"), ("hex8", "tet4")] {
        let column = |name: &str, element: &str, x: f64, traction: f64| {
            format!(
                "[mesh.parts.{name}]\nblock = {{ size = [1, 1, 2], cells = [2, 2, 3], element = \"{element}\" }}\n\
                 move = [{x}, 0, 0]\n[[fix]]\non = \"{name}.z-min\"\n[[load]]\non = \"{name}.z-max\"\n\
                 traction = [0, 0, \"{traction}*t\"]\n"
            )
        };
        let case = [
            "[materials.steel]\nyoung = 1e5\npoisson = 0\n[[step]]\nuntil = 1\nincrements = 2\n".into(),
            column("a", left, 0.0, 3.0),
            column("b", right, 5.0, 10.0),
        ];
        let folder = Folder::new(&format!("report-kinds-{left}"), &case.concat());
        folder.run(&["solve", "case.toml", "-o", "r"]).ends(0, &[]);
        let read = || view(&std::fs::read_to_string(folder.path.join("r/report.html")).unwrap());
        let with_mesh = read();
        folder.run(&["report", "r"]).ends(0, &[]);
        assert_eq!(read(), with_mesh);
        let high = number(&with_mesh["high"][0]);
        let x = words(&with_mesh["position"]).into_iter().step_by(3).map(|code| f64::from(code) / 65534.0 * high);
        let x: Vec<f64> = x.collect();
        for (frame, t) in with_mesh["frames"].as_array().unwrap().iter().zip([0.5, 1.0]) {
            for (stress, x) in decoded(&frame["values"][0]).into_iter().zip(&x) {
                let expected = if *x < 3.0 { 3.0 * t } else { 10.0 * t };
                assert!((stress - expected).abs() < 1e-3, "{left} at {x}, t = {t}: {stress} for {expected}");
            }
        }
    }
}

/// Two pads on one plate: the plate is shown once, with the pressure of both pads, and so is each pad.
#[test]
fn the_view_shows_both_sides_of_every_pair() {
    let block = |name: &str, size: &str, cells: &str, at: &str| {
        format!(
            "[mesh.parts.{name}]\nblock = {{ size = [{size}], cells = [{cells}], element = \"hex8\" }}\nmove = [{at}]\n"
        )
    };
    let contact = |pad: &str| {
        format!("[[contact]]\non = \"{pad}.z-min\"\nagainst = \"plate.z-max\"\nfriction = \"bonded\"\nslave = \"on\"\n")
    };
    let case = [
        "title = \"Two pads\"\n".into(),
        block("plate", "3, 1, 1", "6, 2, 2", "0, 0, 0"),
        block("left", "1, 1, 1", "3, 3, 1", "0, 0, 1"),
        block("right", "1, 1, 1", "3, 3, 1", "2, 0, 1"),
        "[materials.steel]\nyoung = 1e5\npoisson = 0\n[[fix]]\non = \"plate.z-min\"\n".into(),
        "[[load]]\non = [\"left.z-max\", \"right.z-max\"]\npressure = 1\n".into(),
        contact("left"),
        contact("right"),
    ];
    let folder = Folder::new("report-sides", &case.concat());
    folder.run(&["solve", "case.toml", "-o", "r"]).ends(0, &[]);
    let view = view(&std::fs::read_to_string(folder.path.join("r/report.html")).unwrap());
    let corners = words(&view["faces"]);
    // The boundaries of 6 x 2 x 2 and twice 3 x 3 x 1 hexahedra; in contact 12 faces of the plate and 9 of each pad.
    assert_eq!(corners.len() / 4, 2 * (12 + 12 + 4) + 2 * 2 * (9 + 3 + 3));
    let first = view["firstContactFace"].as_u64().unwrap() as usize;
    assert_eq!(corners.len() / 4 - first, 12 + 2 * 9);
    let pressure = decoded(&view["frames"][0]["values"][1]);
    let of_face = |face: &[u16]| face.iter().map(|&v| pressure[v as usize]).collect::<Vec<f64>>();
    let faces: Vec<Vec<f64>> = corners[4 * first..].chunks(4).map(of_face).collect();
    // Below each pad 4 faces of the plate, between the pads 4 more, which see one of them at two nodes each.
    let seen = faces.iter().filter(|p| p.iter().all(|p| *p > 0.2)).count();
    let beside = faces.iter().filter(|p| p.iter().filter(|p| p.is_nan()).count() == 2).count();
    assert_eq!((seen, beside), (2 * 9 + 8, 4), "{faces:?}");
}

/// A browser: what the variable names, or the first of the usual ones on the path.
fn browser() -> Option<PathBuf> {
    if let Some(named) = std::env::var_os("STICTION_BROWSER") {
        return Some(PathBuf::from(named));
    }
    let folders: Vec<PathBuf> = std::env::split_paths(&std::env::var_os("PATH")?).collect();
    let names = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "headless_shell"];
    names.iter().find_map(|name| folders.iter().map(|folder| folder.join(name)).find(|path| path.is_file()))
}

/// Runs the browser on the report with one more option; what it printed and what it complained about.
fn browse(browser: &Path, folder: &Folder, option: &str) -> (String, String) {
    let output = Command::new(browser)
        .args(["--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--use-angle=swiftshader"])
        .args(["--enable-unsafe-swiftshader", "--ignore-gpu-blocklist", "--hide-scrollbars", "--no-first-run"])
        .args(["--enable-logging=stderr", "--virtual-time-budget=5000", "--window-size=1200,1400"])
        .arg(format!("--user-data-dir={}", folder.path.join("profile").display()))
        .arg(option)
        .arg(format!("file://{}", folder.path.join("r/report.html").display()))
        .output()
        .unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let (out, err) = (text(&output.stdout), text(&output.stderr));
    assert!(output.status.success(), "{err}");
    (out, err)
}

/// Different colours of the picture that are no grey.
fn colours(path: &Path) -> usize {
    let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    // The upper part only: title, verdict, numbers and the view; the pictures come below it.
    let (width, samples) = (info.width as usize, info.color_type.samples());
    let rows = pixels.chunks_exact(width * samples).take(1100);
    let coloured = |p: &&[u8]| p[..3].iter().max().unwrap() - p[..3].iter().min().unwrap() > 40;
    let all: std::collections::HashSet<[u8; 3]> =
        rows.flat_map(|row| row.chunks_exact(samples)).filter(coloured).map(|p| [p[0], p[1], p[2]]).collect();
    all.len()
}

#[test]
fn a_browser_draws_the_view_without_complaint() {
    let Some(browser) = browser() else {
        // Not by the macro, whose words the harness would keep to itself.
        let words = b"NOT TESTED: no browser is installed, so report.html was looked at by structure only\n";
        std::io::stderr().write_all(words).unwrap();
        return;
    };
    let (folder, _) = solved("report-browser");
    let (dom, complaints) = browse(&browser, &folder, "--dump-dom");
    assert!(dom.contains("data-viewer=\"ready\""), "the view was not drawn: {complaints}");
    assert!(!dom.contains("data-error=") && !dom.contains("id=\"owned\""));
    assert!(!complaints.contains("CONSOLE"), "{complaints}");
    // What the script writes beside the picture: all fields, and the colour bar of the first.
    assert_eq!(dom.matches("<option value=\"").count(), 4 + 7 + 3);
    let summary = folder.summary("r");
    // The bar is the same for all steps.
    let steps = summary["steps"].as_array().unwrap().iter();
    let largest = steps.map(|step| number(&step["displacement_max"])).fold(0.0, f64::max);
    let tick = elements(&dom, "span").into_iter().filter_map(|text| text.parse().ok()).fold(0.0, f64::max);
    assert!((tick / largest - 1.0).abs() < 5e-3, "the colour bar ends at {tick}, the displacement at {largest}");
    let picture = folder.path.join("page.png");
    browse(&browser, &folder, &format!("--screenshot={}", picture.display()));
    // The verdict and the axes alone have a handful; a drawn body has the shades of its field.
    let colours = colours(&picture);
    println!("{colours} colours");
    assert!(colours > 300, "{colours}");
}

/// The long run is `bench/campaigns/hostile`.
#[test]
fn hostile_names_become_neither_markup_nor_commands_of_a_terminal() {
    let browser = browser();
    let command = Path::new(env!("CARGO_BIN_EXE_stiction"));
    let report = stiction_fixtures::hostile::campaign(command, browser.as_deref(), 1, 20);
    assert!(report.findings.is_empty() && report.solved > 10, "{report:#?}");
    assert_eq!(report.browsed, if browser.is_some() { report.solved } else { 0 });
}
