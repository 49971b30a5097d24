//! What contact does to surfaces over load steps, on slides that are known.

use std::ops::ControlFlow;

use stiction::io::case;
use stiction::run::{self, Ahead, Origin, Settings};
use stiction_fixtures::folder::Folder;

const YOUNG: f64 = 1000.0;
const MU: f64 = 0.25;
const WEAR: f64 = 1e-6;
/// Faces of the block on the plane are 2 by 1, two blocks are 4 by 2 and 4 high.
const AREA: f64 = 8.0;
/// The top goes down by this, then to and fro.
const DOWN: f64 = 0.01;
const PRESSURE: f64 = YOUNG * DOWN / 4.0;
/// Where the foot has slid to at the ends of the load steps.
const PLACES: [f64; 4] = [0.3, -0.3, 0.3, 0.1];

/// Shear stress where all of it slides, and the stress along the plane.
const SHEAR: f64 = MU * PRESSURE;
const PULL: f64 = 2.0;

/// A value that is `values[k]` at the time `k + 1`.
fn course(values: &[f64]) -> String {
    let mut text = format!("{} * min(t, 1)", values[0]);
    for (k, ends) in values.windows(2).enumerate() {
        text += &format!(" + {} * max(0, min(t - {}, 1))", ends[1] - ends[0], k + 1);
    }
    text
}

/// A block without lateral contraction in uniform stress: pressed, pulled along the plane by `pull`, and sheared by the friction
/// of its foot, which is at `places` at the times 1, 2 and so on.
fn to_and_fro(places: &[f64], pull: f64, more: &str) -> String {
    let from = |k: usize| if k == 0 { 0.0 } else { places[k - 1] };
    let shear: Vec<f64> = (0..places.len()).map(|k| SHEAR * (places[k] - from(k)).signum()).collect();
    // The shear modulus is half of Young's, the block 4 high.
    let top: Vec<f64> = places.iter().zip(&shear).map(|(place, shear)| place + 4.0 * shear / (YOUNG / 2.0)).collect();
    let (top, shear, back) = (course(&top), course(&shear), course(&shear.iter().map(|s| -s).collect::<Vec<_>>()));
    let steps: String = (1..=places.len()).map(|t| format!("[[step]]\nuntil = {t}\nincrements = 1\n")).collect();
    format!(
        "units = \"mm, N, MPa\"\n[mesh]\nblock = {{ size = [4, 2, 4], cells = [2, 2, 2], element = \"hex8\" }}\n\
         [materials.m]\nyoung = {YOUNG}\npoisson = 0\n\
         [[fix]]\non = \"z-max\"\nvalue = [\"{top} + {} * x\", 0, -{DOWN}]\n\
         [[load]]\non = \"x-max\"\ntraction = [{pull}, 0, \"{shear}\"]\n\
         [[load]]\non = \"x-min\"\ntraction = [-{pull}, 0, \"{back}\"]\n\
         [[contact]]\non = \"z-min\"\nname = \"foot\"\nagainst = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}\n\
         friction = {{ coulomb = {MU} }}\n{more}{steps}",
        pull / YOUNG
    )
}

/// Solves the case in `folder` and returns the last file of the contact, without its head.
fn table(text: &str, folder: &Folder) -> (Vec<String>, Vec<Vec<String>>) {
    let case = case::parse(text, "case.toml", &[]).unwrap_or_else(|e| panic!("{e}"));
    let mut prepared = run::prepare(&case).unwrap();
    let settings = Settings::of(&case.solver);
    let (mut files, _) = run::begin_steps(&prepared, &folder.path, false).unwrap();
    let mut keep = |prepared: &run::Prepared, step: &run::Step| run::keep_step(&mut files, prepared, step);
    let mut outcome =
        run::solve_steps(&mut prepared, &settings, None, &mut keep, &mut |_| ControlFlow::Continue(())).unwrap();
    assert!(outcome.solution.certificate.passed);
    run::write_with(&prepared, &mut outcome, &Origin::default(), &folder.path, Ahead::default()).unwrap();
    let csv = std::fs::read_to_string(folder.at(format!("contact-{:04}.csv", outcome.steps.len()))).unwrap();
    let mut lines = csv.lines().map(|line| line.split(',').map(str::to_string).collect::<Vec<_>>());
    let head = lines.next().unwrap();
    (head, lines.collect())
}

fn column((head, rows): &(Vec<String>, Vec<Vec<String>>), name: &str) -> Vec<f64> {
    let at = head.iter().position(|h| h == name).unwrap_or_else(|| panic!("{name} is not in {head:?}"));
    rows.iter().map(|row| row[at].parse().unwrap_or(f64::NAN)).collect()
}

fn all_are(values: &[f64], wanted: f64) {
    assert!(!values.is_empty());
    for value in values {
        assert!((value - wanted).abs() <= 1e-8 * wanted.abs(), "{value} where {wanted} is wanted");
    }
}

/// Work of friction is mu p times the path, the depth of wear k p times it (Archard), Ruiz's first parameter the shear times half of
/// how far the ends of the slide are apart.
#[test]
fn a_block_that_slides_to_and_fro_does_the_work_of_its_friction() {
    let folder = Folder::new("fretting");
    let table = table(&to_and_fro(&PLACES, 0.0, &format!("wear = {WEAR}\n")), &folder);
    let path: f64 = PLACES[0] + PLACES.windows(2).map(|ends| (ends[1] - ends[0]).abs()).sum::<f64>();
    let (shear, amplitude) = (SHEAR, 0.3);
    all_are(&column(&table, "pressure [MPa]"), PRESSURE);
    all_are(&[column(&table, "area [mm^2]").iter().sum()], AREA);
    all_are(&column(&table, "slip_x [mm]"), PLACES[3] - PLACES[2]);
    all_are(&column(&table, "slid_x [mm]"), PLACES[3]);
    all_are(&column(&table, "step_work [MPa mm]"), shear * 0.2);
    all_are(&column(&table, "work [MPa mm]"), shear * path);
    all_are(&column(&table, "path [mm]"), path);
    all_are(&column(&table, "slip_amplitude [mm]"), amplitude);
    all_are(&column(&table, "shear_amplitude [MPa]"), shear);
    all_are(&column(&table, "ruiz_1 [MPa mm]"), shear * amplitude);
    all_are(&column(&table, "wear [mm]"), WEAR * PRESSURE * path);
    // Nothing pulls along the surface: the stress is uniform pressure across it.
    assert!(column(&table, "max_tension [MPa]").iter().all(|tension| tension.abs() < 1e-9 * PRESSURE));
    let summary = std::fs::read_to_string(folder.at("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    let fretting = &summary["fretting"][0];
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    all_are(&[number(&fretting["work"]), number(&summary["balance"]["dissipation"])], AREA * shear * path);
    all_are(&[number(&fretting["max_wear"])], WEAR * PRESSURE * path);
    all_are(&[number(&fretting["worn_volume"])], AREA * WEAR * PRESSURE * path);
    let micromotion = &summary["pairs"][0]["micromotion"];
    all_are(&["p50", "p90", "p95", "max"].map(|key| number(&micromotion[key])), PLACES[3]);
}

/// Wear is off unless a coefficient is given, and is nothing then.
#[test]
fn without_a_coefficient_no_wear_is_reported() {
    let folder = Folder::new("fretting-without-wear");
    let table = table(&to_and_fro(&PLACES[..1], 0.0, ""), &folder);
    assert!(column(&table, "wear [mm]").iter().all(|depth| depth.is_nan()));
    let summary = std::fs::read_to_string(folder.at("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    assert!(summary["fretting"][0].get("max_wear").is_none() && summary["fretting"][0]["work"].is_number());
}

/// A bar pulled along the plane it is pressed on: Ruiz's second parameter is the first times the tension along the surface.
#[test]
fn the_second_parameter_of_ruiz_is_the_first_times_the_tension_along_the_surface() {
    let folder = Folder::new("fretting-tension");
    let table = table(&to_and_fro(&[0.3, -0.1], PULL, ""), &folder);
    let (first, second) = (column(&table, "ruiz_1 [MPa mm]"), column(&table, "ruiz_2 [MPa^2 mm]"));
    let (tension, shear) = (column(&table, "max_tension [MPa]"), column(&table, "max_shear [MPa]"));
    all_are(&tension, PULL);
    for (((first, second), tension), shear) in first.iter().zip(&second).zip(&tension).zip(&shear) {
        all_are(&[*first], 0.2 * shear);
        all_are(&[*second], tension * first);
        all_are(&[*shear], SHEAR);
    }
}

/// A finely meshed pad that is rubbed over a coarse plate: the work of the points adds up to what the bodies lose, and by Archard's law the
/// worn volume is that over the coefficient of friction. The sums over the points leave the rims out to a percent.
#[test]
fn between_meshes_that_do_not_match_the_work_of_the_points_is_the_dissipation() {
    let folder = Folder::new("fretting-between-bodies");
    let text = format!(
        "units = \"mm, N, MPa\"\n[mesh.parts.plate]\nblock = {{ size = [30, 20, 10], cells = [6, 4, 2], element = \"hex8\" }}\n\
         [mesh.parts.pad]\nblock = {{ size = [16, 12, 8], cells = [16, 12, 4], element = \"hex8\" }}\nmove = [7, 4, 10]\n\
         [materials.m]\nyoung = 210e3\npoisson = 0.3\n[[fix]]\non = \"plate.z-min\"\n\
         [[load]]\non = \"pad.z-max\"\nforce = [\"80*(min(1,max(0,t-1))-2*min(1,max(0,t-2)))\", \"30*sin(3*t)\", \"-1000*min(t,1)\"]\n\
         [[contact]]\non = \"pad.z-min\"\nagainst = \"plate.z-max\"\nfriction = {{ coulomb = {MU} }}\nwear = {WEAR}\n\
         [[step]]\nuntil = 1\nincrements = 1\n[[step]]\nuntil = 3\nincrements = 6\n"
    );
    let table = table(&text, &folder);
    let summary = std::fs::read_to_string(folder.at("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    let fretting = &summary["fretting"][0];
    let steps = summary["steps"].as_array().unwrap();
    let lost = number(&steps.last().unwrap()["balance"]["dissipation"]);
    let (work, volume) = (number(&fretting["work"]), number(&fretting["worn_volume"]));
    assert!(lost > 0.0 && (work / lost - 1.0).abs() < 0.01, "{work} of {lost}");
    assert!((MU * volume / WEAR / lost - 1.0).abs() < 0.01, "{volume} by Archard, {lost} lost");
    // So does the last step alone, and no point gains energy from friction.
    let (areas, of_step) = (column(&table, "area [mm^2]"), column(&table, "step_work [MPa mm]"));
    assert!(of_step.iter().all(|work| work.is_nan() || *work >= 0.0));
    let sum: f64 = areas.iter().zip(&of_step).filter(|(_, work)| work.is_finite()).map(|(a, w)| a * w).sum();
    let before = number(&steps[steps.len() - 2]["balance"]["dissipation"]);
    assert!((sum / (lost - before) - 1.0).abs() < 0.01, "{sum} of {}", lost - before);
}
