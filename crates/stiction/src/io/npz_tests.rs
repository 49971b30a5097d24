use super::*;

fn scratch(name: &str) -> std::path::PathBuf {
    std::env::temp_dir().join(format!("stiction-{}-{name}", std::process::id()))
}

fn example() -> Vec<(&'static str, Array<'static>)> {
    vec![
        ("lambda", Array::f64(&[1.0 / 3.0, -0.0, f64::INFINITY])),
        ("nodes", Array { shape: vec![2, 3], data: Data::F64(vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0].into()) }),
        ("column", Array::u32(&[0, 7, u32::MAX])),
        ("start", Array::usize(&[0, 2, 3])),
        ("time", Array::scalar(0.5)),
        ("n", Array::count(42)),
        ("title", Array::text("Klötzchen")),
        ("empty", Array::f64(&[])),
    ]
}

#[test]
fn what_is_written_is_read_back() {
    let path = scratch("all.npz");
    write(&path, &example()).unwrap();
    let arrays = read(&path).unwrap();
    for (name, array) in &example() {
        assert_eq!(&arrays[*name], array);
    }
    assert_eq!(u32s(&arrays, "column", Some(3)).unwrap(), [0, 7, u32::MAX]);
    assert_eq!(usizes(&arrays, "start", None).unwrap(), [0, 2, 3]);
    assert_eq!(count(&arrays, "n").unwrap(), 42);
    assert_eq!(scalar(&arrays, "time").unwrap(), 0.5);
    assert_eq!(text(&arrays, "title").unwrap(), "Klötzchen");
    std::fs::remove_file(path).unwrap();
}

/// A disk with room for so many bytes, and how often it has refused what does not fit or comes later.
struct Small {
    room: usize,
    refused: usize,
}

impl Write for Small {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.refused > 0 || self.room < bytes.len() {
            self.refused += 1;
            return Err(io::ErrorKind::StorageFull.into());
        }
        self.room -= bytes.len();
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Small {
    fn seek(&mut self, _: io::SeekFrom) -> io::Result<u64> {
        Ok(0)
    }
}

/// The archive ends itself when it is dropped, and would print that it cannot.
#[test]
fn a_full_disk_is_told_once() {
    let mut disk = Small { room: 100, refused: 0 };
    let mut archive = ZipWriter::new(Quiet { to: &mut disk, at: 0, failed: false });
    let numbers = [1.0; 100];
    let error = put((&mut archive, "x.npy"), &[100], [&numbers[..]].into_iter()).unwrap_err();
    assert_eq!(error.kind(), io::ErrorKind::StorageFull);
    drop(archive);
    assert_eq!(disk.refused, 1);
}

#[test]
fn missing_and_unfitting_arrays_are_named() {
    let arrays: Arrays = example().into_iter().map(|(n, a)| (n.to_string(), a)).collect();
    let error = f64s(&arrays, "lamda", None).unwrap_err().to_string();
    assert!(error.contains("no array \"lamda\"") && error.contains("lambda"), "{error}");
    let error = f64s(&arrays, "lambda", Some(4)).unwrap_err().to_string();
    assert!(error.contains("[3]") && error.contains("a list of 4 float64"), "{error}");
    assert!(f64s(&arrays, "column", None).unwrap_err().to_string().contains("uint32"));
    assert!(f64s(&arrays, "nodes", None).is_err() && text(&arrays, "n").is_err() && scalar(&arrays, "nodes").is_err());
}

#[test]
fn truncated_and_corrupted_files_are_errors_and_no_panics() {
    let path = scratch("damaged.npz");
    write(&path, &example()).unwrap();
    let whole = std::fs::read(&path).unwrap();
    for length in (0..whole.len()).step_by(7) {
        std::fs::write(&path, &whole[..length]).unwrap();
        assert!(read(&path).is_err(), "{length} of {} bytes", whole.len());
    }
    // Many flips hit nothing that matters (dates, padding); the others must not panic.
    let mut refused = 0;
    for at in (0..whole.len()).step_by(3) {
        let mut damaged = whole.clone();
        damaged[at] ^= 0x95;
        std::fs::write(&path, &damaged).unwrap();
        refused += usize::from(read(&path).is_err());
    }
    assert!(refused > whole.len() / 9, "{refused} of {}", whole.len());
    std::fs::remove_file(path).unwrap();
}

#[test]
fn a_header_that_lies_about_its_size_reserves_nothing() {
    let npy =
        |header: &str| [b"\x93NUMPY\x01\x00", &(header.len() as u16).to_le_bytes()[..], header.as_bytes()].concat();
    for shape in ["(999999999999999,)", "(4294967296, 4294967296)", "(1,)", "(-1,)", "((((", ""] {
        let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}");
        assert!(super::npy(&npy(&header)).is_err(), "{shape}");
    }
    assert!(super::npy(&npy("{'descr': '<f8', 'fortran_order': False, 'shape': (0,), }")).is_ok());
    assert!(super::npy(b"\x93NUMPY\x02\x00\xff\xff\xff\xff").is_err());
    assert!(super::npy(b"\x93NUM").is_err());
}

/// As numpy writes `[[1, 2, 3], [4, 5, 6]]` in Fortran order, and in single precision.
#[test]
fn columns_and_single_precision_are_read() {
    let npy = |header: &str, numbers: &[u8]| {
        [b"\x93NUMPY\x01\x00", &(header.len() as u16).to_le_bytes()[..], header.as_bytes(), numbers].concat()
    };
    let header = |kind: &str| format!("{{'descr': '{kind}', 'fortran_order': True, 'shape': (2, 3), }}");
    let columns = [1.0f64, 4.0, 2.0, 5.0, 3.0, 6.0];
    let double: Vec<u8> = columns.iter().flat_map(|x| x.to_le_bytes()).collect();
    let single: Vec<u8> = columns.iter().flat_map(|x| (*x as f32).to_le_bytes()).collect();
    for (kind, numbers) in [("<f8", double), ("<f4", single)] {
        let array = super::npy(&npy(&header(kind), &numbers)).unwrap();
        assert_eq!(array, Array { shape: vec![2, 3], data: Data::F64(vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0].into()) });
    }
    let error = super::npy(&npy(&header("<c8"), &[0; 48])).unwrap_err().to_string();
    assert!(error.contains("of kind <c8") && error.contains("astype(float)"), "{error}");
}

#[test]
fn arrays_that_contradict_themselves_are_not_written() {
    let path = scratch("refused.npz");
    let array = Array { shape: vec![2, 2], data: Data::F64(vec![1.0].into()) };
    assert!(write(&path, &[("K", array)]).unwrap_err().to_string().contains("\"K\""));
    let twice = [("a", Array::scalar(1.0)), ("a", Array::scalar(2.0))];
    assert!(write(&path, &twice).unwrap_err().to_string().contains("two arrays"));
    assert!(!path.exists());
}
