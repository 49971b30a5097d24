use std::path::PathBuf;

use super::*;

/// A folder of its own for each test, removed at its end.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("stiction-plot-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        Scratch(folder)
    }

    fn path(&self) -> PathBuf {
        self.0.join("picture.png")
    }

    /// Width, height and pixels of the picture as its file has them.
    fn picture(&self, drawing: &Drawing) -> (usize, usize, Vec<u8>) {
        drawing.write_png(&self.path()).unwrap();
        let bytes = std::fs::read(self.path()).unwrap();
        assert!(bytes.starts_with(b"\x89PNG\r\n\x1a\n"));
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        (info.width as usize, info.height as usize, pixels)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// A square of `n x n` quadrilaterals with a side of 2 around the origin of the x-y plane.
fn square(n: u32) -> (Vec<[f64; 3]>, Vec<[u32; 4]>) {
    let along = |i: u32| 2.0 * f64::from(i) / f64::from(n) - 1.0;
    let points = (0..=n).flat_map(|j| (0..=n).map(move |i| [along(i), along(j), 0.0])).collect();
    let corner = |i, j| i + j * (n + 1);
    let face = |i, j| [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
    (points, (0..n).flat_map(|j| (0..n).map(move |i| face(i, j))).collect())
}

fn slices(faces: &[[u32; 4]]) -> Vec<&[u32]> {
    faces.iter().map(|f| &f[..]).collect()
}

fn map<'a>(points: &'a [[f64; 3]], faces: &'a [&'a [u32]], values: MapValues<'a>) -> SurfaceMap<'a> {
    let (title, label, unit_label, length_label) = ("Pressure", "Pressure", "Pa", "m");
    SurfaceMap { points, faces, values, vectors: None, focus: None, title, label, unit_label, length_label }
}

#[test]
fn a_constant_pressure_colours_its_area_in_one_colour() {
    let scratch = Scratch::new("constant");
    let (points, faces) = square(4);
    let faces = slices(&faces);
    let drawing = surface_map(&map(&points, &faces, MapValues::Scalar(&[3.0; 25]))).unwrap();
    let (width, height, pixels) = scratch.picture(&drawing);
    assert_eq!((width, height), (1400, 1020));
    // The square fills the height of 760 pixels, but for its border, inner edges and the top of the colour bar.
    let yellow = pixels.chunks_exact(3).filter(|p| **p == [253, 231, 37]).count() as f64;
    assert!((yellow / (760.0 * 760.0) - 1.0).abs() < 0.03, "{yellow}");
}

#[test]
fn a_missing_value_is_grey_and_a_state_takes_its_own_quarter() {
    let scratch = Scratch::new("status");
    let (points, faces) = square(1);
    let faces = slices(&faces);
    let count = |pixels: &[u8], color: [u8; 3]| pixels.chunks_exact(3).filter(|p| **p == color).count() as f64;
    let pixels = |values: MapValues| scratch.picture(&surface_map(&map(&points, &faces, values)).unwrap()).2;
    let missing = pixels(MapValues::Scalar(&[1.0, 1.0, 1.0, f64::NAN]));
    assert!(count(&missing, color::MISSING) > 0.9 * 760.0 * 760.0);
    let pixels = pixels(MapValues::Status(&[0, 1, 2, 1]));
    for (state, quarters) in [(1, 2.0), (2, 1.0)] {
        let share = count(&pixels, color::STATUS[state].1) / (760.0 * 760.0 / 4.0);
        assert!((share - quarters).abs() < 0.03, "state {state}: {share}");
    }
}

#[test]
fn a_ball_is_drawn_in_space_and_a_plate_as_a_map() {
    let tetrahedron = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let faces: [&[u32]; 4] = [&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[0, 3, 2]];
    let vectors = MapVectors { values: &tetrahedron, label: "Shear traction", unit_label: "Pa" };
    let closed = map(&tetrahedron, &faces, MapValues::Scalar(&[0.0, 1.0, 2.0, 3.0]));
    assert_eq!(surface_map(&SurfaceMap { vectors: Some(vectors), ..closed }).unwrap().height, 1000);
    // A strip twenty times as long as wide needs no high picture.
    let strip = [[0.0, 0.0, 0.0], [20.0, 0.0, 0.0], [20.0, 0.6, 0.8], [0.0, 0.6, 0.8]];
    let faces: [&[u32]; 1] = [&[0, 1, 2, 3]];
    assert!(surface_map(&map(&strip, &faces, MapValues::Scalar(&[0.0, 1.0, 2.0, 3.0]))).unwrap().height < 700);
}

#[test]
fn a_stretched_bar_is_enlarged_by_the_factor_returned() {
    let (points, faces) = square(3);
    let faces = slices(&faces);
    let displacement: Vec<[f64; 3]> = points.iter().map(|p| [1e-4 * (p[0] + 1.0), 0.0, 0.0]).collect();
    let plot = DeformedPlot {
        points: &points,
        faces: &faces,
        displacement: &displacement,
        title: "Bar",
        unit_label: "m",
        scale: None,
    };
    // 8 % of the diagonal 2 sqrt(2) over the largest displacement of 2e-4 is 1131.
    assert_eq!(deformed(&plot).unwrap().1, 1000.0);
    let (drawing, scale) = deformed(&DeformedPlot { scale: Some(7.0), ..plot }).unwrap();
    assert_eq!((drawing.width, drawing.height, scale), (1400, 1000, 7.0));
    let error = deformed(&DeformedPlot { scale: Some(-1.0), ..plot }).unwrap_err().to_string();
    assert!(error.contains("-1"), "{error}");
    assert!(deformed(&DeformedPlot { displacement: &displacement[1..], ..plot }).is_err());
    let stray: [&[u32]; 1] = [&[0, 1, 99]];
    let error = deformed(&DeformedPlot { faces: &stray, ..plot }).unwrap_err().to_string();
    assert!(error.contains("face 0") && error.contains("node 99"), "{error}");
}

#[test]
fn degenerate_input_makes_a_picture_and_no_panic() {
    let scratch = Scratch::new("degenerate");
    let nan = [f64::NAN; 3];
    let huge = [f64::MAX, -f64::MAX, f64::INFINITY];
    let points_of: [&[[f64; 3]]; 6] = [
        &[],
        &[[1.0, 2.0, 3.0]],
        &[[1.0; 3]; 3],
        &[nan, huge, [0.0; 3]],
        &[[1e300; 3], [-1e300; 3], [0.0; 3]],
        &[[1e-300, 0.0, 0.0], [0.0; 3], [0.0, 1e-300, 0.0]],
    ];
    let triangle: [&[u32]; 1] = [&[0, 1, 2]];
    // Each surface meets two of the values; together they meet all.
    let values = [0.0, f64::NAN, 5.0, f64::NEG_INFINITY, f64::MAX, 1e-310];
    for (i, points) in points_of.into_iter().enumerate() {
        let faces = if points.len() < 3 { &[][..] } else { &triangle[..] };
        for value in [values[i], values[(i + 3) % 6]] {
            let scalars = vec![value; points.len()];
            let vectors = vec![[value, 0.0, -value]; points.len()];
            let vectors = Some(MapVectors { values: &vectors, label: "", unit_label: "" });
            let plain = map(points, faces, MapValues::Scalar(&scalars));
            scratch.picture(&surface_map(&SurfaceMap { vectors, ..plain }).unwrap());
            let displacement = vec![[value; 3]; points.len()];
            let (title, unit_label) = ("", "");
            let plot = DeformedPlot { points, faces, displacement: &displacement, title, unit_label, scale: None };
            let (drawing, scale) = deformed(&plot).unwrap();
            assert!(scale > 0.0);
            scratch.picture(&drawing);
        }
        let states = vec![200; points.len()];
        scratch.picture(&surface_map(&map(points, &[], MapValues::Status(&states))).unwrap());
    }
}

#[test]
fn convergence_pictures_cope_with_any_history() {
    let scratch = Scratch::new("convergence");
    let point = |i: usize, residual: f64| ConvergencePoint { iteration: i, products: 3 * i, residual };
    let falling: Vec<_> = (0..300).map(|i| point(i, 10f64.powf(-0.03 * i as f64))).collect();
    let odd =
        [point(0, 1.0), point(1, 0.0), point(2, f64::NAN), point(3, f64::INFINITY), point(usize::MAX / 3, 1e-300)];
    let histories: [(&[ConvergencePoint], f64); 5] =
        [(&falling, 1e-8), (&[], 1e-8), (&[], 0.0), (&[point(0, 1e-12)], f64::NAN), (&odd, 1e-6)];
    for (points, tolerance) in histories {
        let drawing = convergence(points, tolerance, &"A title much too long for the picture. ".repeat(9));
        let (width, height, pixels) = scratch.picture(&drawing);
        assert_eq!((width, height), (1400, 900));
        assert!(pixels.iter().any(|&c| c < 60));
    }
}
