use super::*;
use crate::Error;

fn parse(text: &str) -> Result<Field, Error> {
    compile(text, &VARIABLES).map_err(|fault| {
        let column = text[..fault.span.start].chars().count() + 1;
        Error::new(format!("character {column} of the expression"), fault.what, fault.remedy)
    })
}

fn value(text: &str, x: [f64; 3], t: f64) -> f64 {
    match parse(text) {
        Ok(field) => field.at(x, t),
        Err(error) => panic!("{text}: {error}"),
    }
}

fn fault(text: &str) -> Error {
    match parse(text) {
        Err(error) => error,
        Ok(field) => panic!("{text} was read as {field:?}"),
    }
}

#[test]
fn expressions_have_the_value_an_engineer_computes_by_hand() {
    let (x, t) = ([3.0, 0.5, -2.0], 4.0);
    let cases = [
        ("-x^2", -9.0),
        ("(-x)^2", 9.0),
        ("2^-x", 0.125),
        ("-2^-2", -0.25),
        ("2*-x", -6.0),
        ("2 - -x", 5.0),
        ("--x", 3.0),
        ("+x", 3.0),
        ("2-3-4", -5.0),
        ("2-(3-4)", 3.0),
        ("8/4/2", 1.0),
        ("8/4*2", 4.0),
        ("8/(4*2)", 1.0),
        ("1+2*x^2", 19.0),
        ("-2/3*1e6*(4 - x)", -2.0 / 3.0 * 1e6),
        ("2*x**2", 18.0),
        ("(2^x)^2", 64.0),
        ("2^(x^2)", 512.0),
        ("2^(-x^2 + 10)", 2.0),
        ("1.5e-3*1E+3", 1.5),
        (".5 + 2.", 2.5),
        ("cos(pi) + sin(π/2) + PI - pi", 0.0),
        ("-sin(pi/2)^2", -1.0),
        ("atan2(y, x) - atan(y/x)", 0.0),
        ("min(1, max(2, x)) + max(min(x, 1), 0)", 2.0),
        ("min(max(1, 2), max(3, 4))*10", 20.0),
        ("ln(exp(z))", -2.0),
        ("log10(1000)", 3.0),
        ("abs(z)*sqrt(16) + floor(2.7)", 10.0),
        ("tanh(0) + sinh(0) + cosh(0)", 1.0),
        ("asin(1) + acos(1) - pi/2 + tan(0)", 0.0),
        ("x + y + z + t", 5.5),
        (" \t( x )\n", 3.0),
        ("z^2", 4.0),
    ];
    for (text, expected) in cases {
        let found = value(text, x, t);
        // A handful of rounding errors of values of this size.
        assert!((found - expected).abs() <= 8.0 * f64::EPSILON * (1.0 + expected.abs()), "{text} gave {found}");
    }
}

#[test]
fn an_expression_without_variables_is_a_constant() {
    assert!(matches!(parse("2*(3 + 4)"), Ok(Field::Constant(14.0))));
    assert!(matches!(parse("0*x"), Ok(Field::Function { .. })));
}

#[test]
fn a_mistake_is_not_hidden_by_min_or_max() {
    assert!(value("min(1, sqrt(x))", [-1.0; 3], 0.0).is_nan());
    assert!(value("max(sqrt(x), 1)", [-1.0; 3], 0.0).is_nan());
}

#[test]
fn faults_are_placed_and_explained() {
    let cases = [
        ("", 1, "empty"),
        ("  ", 3, "empty"),
        ("1+", 3, "ends"),
        (")", 1, "')'"),
        ("1 + * 2", 5, "'*'"),
        ("x y", 3, "operator missing"),
        ("2x", 2, "2*x"),
        ("2(x)", 2, "2*x"),
        ("(1+2", 5, "not closed"),
        ("1,5", 2, "decimals take a point"),
        ("(1,5)", 3, "decimals take a point"),
        ("1..2", 3, "not expected"),
        (".", 1, "not a finite number"),
        ("1e999", 1, "not a finite number"),
        ("1e", 2, "operator missing"),
        ("1/0", 1, "value inf"),
        ("sqrt(-1)", 1, "value NaN"),
        ("2^3^2", 4, "(a^b)^c"),
        ("2^-3^2", 5, "(a^b)^c"),
        ("r + 1", 1, "x, y, z, t"),
        ("1 + X", 5, "x, y, z, t"),
        ("sine(x)", 1, "did you mean sin?"),
        ("log(x)", 1, "ln or log10"),
        ("sin x", 1, "write sin(x)"),
        ("sin(x, y)", 1, "1 argument, but 2 are given"),
        ("min(x)", 1, "2 arguments, but 1 are given"),
        ("sin()", 5, "')'"),
        ("x ≤ 1", 3, "'≤'"),
        ("{x}", 1, "'{'"),
    ];
    for (text, column, part) in cases {
        let error = fault(text);
        assert_eq!(error.place, format!("character {column} of the expression"), "{text}: {error}");
        assert!(error.to_string().contains(part), "{text}: {error}");
    }
}

#[test]
fn monstrous_expressions_are_refused_without_exhausting_the_stack() {
    for text in ["(".repeat(100_000), "-".repeat(4000), "sin(".repeat(1000), "x^(".repeat(1300), "é".repeat(5000)] {
        assert!(parse(&text).is_err());
    }
    let long = format!("x{}", "+x".repeat(2047));
    assert_eq!(value(&long, [1.0; 3], 0.0), 2048.0);
}

#[test]
fn a_variable_that_is_not_allowed_is_named() {
    let fault = compile("2*x", &["t"]).err().unwrap();
    assert!(fault.what.contains("variable x") && fault.remedy.contains("only t"));
    assert_eq!(fault.span, 2..3);
}

#[test]
fn random_texts_never_panic() {
    let alphabet: Vec<char> = "xyzt().,+-*/^ 0123456789eEsincomaxtπ_é\"".chars().collect();
    let mut state = 1u64;
    for _ in 0..20_000 {
        let mut text = String::new();
        let mut next = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as usize
        };
        for _ in 0..next() % 20 {
            text.push(alphabet[next() % alphabet.len()]);
        }
        if let Ok(field) = parse(&text) {
            field.at([0.3, -1.0, 2.0], 1.0);
        }
    }
}
