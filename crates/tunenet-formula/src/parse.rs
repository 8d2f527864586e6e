//! Precedence climbing (Pratt, "Top down operator precedence", POPL 1973), by winnow: text to tree.
//!
//! From loose to tight: `+ -`, `* /`, `-x`, `^` (from the right). A minus before a power acts on the whole power: `-x^2` is
//! −(x²).

use std::ops::Range;

use winnow::ascii::multispace0;
use winnow::combinator::{
    Infix, Prefix, alt, cut_err, delimited, dispatch, expression, fail, opt, preceded, separated,
};
use winnow::error::{StrContext, StrContextValue};
use winnow::stream::LocatingSlice;
use winnow::token::{any, one_of, take_while};
use winnow::{ModalResult, Parser};

use crate::tree::{Node, Tree};
use crate::{FormulaError, Function, LONGEST};

/// Most brackets within brackets.
const DEEPEST: usize = 32;
/// Most operators.
const MOST_OPERATORS: usize = 500;
/// Most signs in a row.
const MOST_SIGNS: usize = 4;

type Input<'a> = LocatingSlice<&'a str>;

const OPERAND: StrContext = StrContext::Expected(StrContextValue::Description("a number, a name, a function or `(`"));
const CLOSED: StrContext = StrContext::Expected(StrContextValue::Description("an operator or `)`"));
const CLOSED_OR_COMMA: StrContext = StrContext::Expected(StrContextValue::Description("an operator, `,` or `)`"));
const END: &str = "an operator or the end of the formula";

/// The tree of a text; its names are not known yet.
pub(crate) fn parse(text: &str) -> Result<Tree, FormulaError> {
    bounded(text)?;
    let mut whole = (sum, multispace0).map(|(tree, _)| tree);
    let tree = whole.parse(LocatingSlice::new(text)).map_err(|error| {
        let at = error.offset();
        if let Some(unknown) = unknown_function(text, at) {
            return unknown;
        }
        let said = error.inner().context().find_map(|context| match context {
            StrContext::Expected(value) => Some(value.to_string()),
            _ => None,
        });
        FormulaError::new(
            place(text, at),
            said.unwrap_or_else(|| END.into()),
            advised(found(text, at), advice(text, at)),
        )
    })?;
    called(&tree)?;
    Ok(tree)
}

/// What is wrong where values in brackets follow a word that is no function.
fn unknown_function(text: &str, at: usize) -> Option<FormulaError> {
    let before = text.get(..at).filter(|_| text[at..].starts_with('('))?.trim_end();
    let start = before.char_indices().rev().take_while(|(_, c)| c.is_alphanumeric() || *c == '_').last()?.0;
    let word = &before[start..];
    if word.starts_with(|c: char| c.is_numeric()) {
        return None;
    }
    let names: Vec<&str> = Function::NAMED.iter().map(|(name, _)| *name).collect();
    let expected = format!("one of the functions {}", names.join(", "));
    let known = names.iter().find(|name| name.eq_ignore_ascii_case(word));
    let advice = match (word.to_ascii_lowercase().as_str(), known) {
        (_, Some(_)) => Some("functions are written in small letters"),
        ("if" | "where" | "ifelse" | "heaviside" | "step", _) => Some(NO_COMPARISON),
        ("log", _) => Some("`ln` is the natural logarithm"),
        ("pow" | "power" | "square", _) => Some(POWER),
        ("fabs" | "norm", _) => Some("`abs` is the absolute value"),
        ("sgn" | "signum", _) => Some("`sign` is the sign"),
        _ => None,
    };
    Some(FormulaError::new(start..before.len(), expected, advised(found(text, start), advice)))
}

const POWER: &str = "a power is written `x^2`";
const PRODUCT: &str = "a product is written `a*b`";
const NO_COMPARISON: &str = "there is no comparison: `sign`, `max`, `min`, `clamp` and `tanh` switch";

/// How a formula writes what other languages write as it stands at this place.
fn advice(text: &str, at: usize) -> Option<&'static str> {
    let (before, rest) = (text.get(..at)?.trim_end(), text.get(at..)?);
    // What ends a value, so that another one may not follow it.
    let is_value = before.ends_with(|c: char| c.is_alphanumeric() || c == ')' || c == '_');
    match rest.chars().next()? {
        '*' if before.ends_with('*') => Some(POWER),
        '<' | '>' | '!' | '&' | '|' | '?' => Some(NO_COMPARISON),
        '=' if rest.starts_with("==") => Some(NO_COMPARISON),
        '=' => Some("what a formula gives is the name of its key"),
        ',' => Some("a decimal number has a point"),
        '\u{2212}' | '\u{2013}' => Some("a minus is written `-`"),
        '\u{b7}' | '\u{d7}' => Some(PRODUCT),
        c if is_value && (c.is_alphanumeric() || c == '(') => Some(PRODUCT),
        _ => None,
    }
}

fn advised(found: String, advice: Option<&str>) -> String {
    match advice {
        Some(advice) => format!("{found}; {advice}"),
        None => found,
    }
}

/// Refuses what is too long or too deep to be followed.
fn bounded(text: &str) -> Result<(), FormulaError> {
    if text.len() > LONGEST {
        let end = (0..=LONGEST).rev().find(|at| text.is_char_boundary(*at)).unwrap_or(0);
        return Err(FormulaError::new(end..end, format!("at most {LONGEST} bytes"), text.len().to_string()));
    }
    let (mut depth, mut operators, mut signs) = (0_usize, 0_usize, 0_usize);
    for (at, c) in text.char_indices().filter(|(_, c)| !c.is_whitespace()) {
        signs = if matches!(c, '+' | '-') { signs + 1 } else { 0 };
        operators += usize::from("+-*/^".contains(c));
        depth = match c {
            '(' => depth + 1,
            ')' => depth.saturating_sub(1),
            _ => depth,
        };
        let (most, count, what) = if depth > DEEPEST {
            (DEEPEST, depth, "brackets within brackets")
        } else if operators > MOST_OPERATORS {
            (MOST_OPERATORS, operators, "operators")
        } else if signs > MOST_SIGNS {
            (MOST_SIGNS, signs, "signs in a row")
        } else {
            continue;
        };
        return Err(FormulaError::new(at..at + c.len_utf8(), format!("at most {most} {what}"), count.to_string()));
    }
    Ok(())
}

/// Refuses functions with another number of values than they take.
fn called(tree: &Tree) -> Result<(), FormulaError> {
    let Node::Call { function, arguments } = &tree.node else { return Ok(()) };
    arguments.iter().try_for_each(called)?;
    if arguments.len() == function.arity() {
        return Ok(());
    }
    let name = Function::NAMED.iter().find(|(_, known)| known == function).map_or("", |(name, _)| name);
    let values = |count: usize| if count == 1 { "1 value".into() } else { format!("{count} values") };
    Err(FormulaError::new(
        tree.place.clone(),
        format!("{} for `{name}`", values(function.arity())),
        values(arguments.len()),
    ))
}

/// The word or sign at a place.
fn place(text: &str, at: usize) -> Range<usize> {
    let rest = text.get(at..).unwrap_or_default();
    let word = rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
    at..at + word.max(rest.chars().next().map_or(0, char::len_utf8))
}

fn found(text: &str, at: usize) -> String {
    match text.get(place(text, at)).unwrap_or_default() {
        "" => "the end".into(),
        word => format!("`{}`", word.chars().take(40).collect::<String>().escape_debug()),
    }
}

fn sum(input: &mut Input) -> ModalResult<Tree> {
    expression(preceded(multispace0, operand))
        .prefix(preceded(
            multispace0,
            // What is neither an operand nor a sign ends the parse here.
            cut_err(one_of(['-', '+']).context(OPERAND)).map(|sign| match sign {
                '-' => Prefix(3, |_, x| Ok(signed(Function::Negate, x))),
                _ => Prefix(3, |_, x| Ok(x)),
            }),
        ))
        .infix(preceded(
            multispace0,
            dispatch! {any;
                '+' => Infix::Left(1, |_, a, b| Ok(both(Function::Add, a, b))),
                '-' => Infix::Left(1, |_, a, b| Ok(both(Function::Subtract, a, b))),
                '*' => Infix::Left(2, |_, a, b| Ok(both(Function::Multiply, a, b))),
                '/' => Infix::Left(2, |_, a, b| Ok(both(Function::Divide, a, b))),
                '^' => Infix::Right(4, |_, a, b| Ok(both(Function::Power, a, b))),
                _ => fail,
            },
        ))
        .parse_next(input)
}

fn signed(function: Function, x: Tree) -> Tree {
    let place = x.place.start.saturating_sub(1)..x.place.end;
    Tree { node: Node::Call { function, arguments: vec![x] }, place }
}

fn both(function: Function, a: Tree, b: Tree) -> Tree {
    let place = a.place.start..b.place.end;
    Tree { node: Node::Call { function, arguments: vec![a, b] }, place }
}

fn operand(input: &mut Input) -> ModalResult<Tree> {
    alt((number, bracket, word)).parse_next(input)
}

fn number(input: &mut Input) -> ModalResult<Tree> {
    let digits = || take_while(0.., |c: char| c.is_ascii_digit());
    let exponent = opt((alt(('e', 'E')), opt(alt(('+', '-'))), take_while(1.., |c: char| c.is_ascii_digit())));
    (digits(), opt(('.', digits())), exponent)
        .take()
        .verify_map(|text: &str| text.parse::<f64>().ok().filter(|value| value.is_finite()))
        .with_span()
        .map(|(value, place)| Tree { node: Node::Number(value), place })
        .parse_next(input)
}

fn bracket(input: &mut Input) -> ModalResult<Tree> {
    delimited('(', sum, (multispace0, cut_err(')'.context(CLOSED))))
        .with_span()
        .map(|(inside, place)| Tree { place, ..inside })
        .parse_next(input)
}

/// A name, or a function with its values.
fn word(input: &mut Input) -> ModalResult<Tree> {
    let letters = (
        take_while(1, |c: char| c.is_alphabetic() || c == '_'),
        take_while(0.., |c: char| c.is_alphanumeric() || c == '_'),
    );
    let name = letters.take().parse_next(input)?;
    let end = winnow::stream::Location::current_token_start(input);
    let place = end - name.len()..end;
    let Some(function) = Function::named(name) else {
        return Ok(Tree { node: Node::Name { text: name.to_owned(), index: usize::MAX }, place });
    };
    let values = separated(1.., sum, (multispace0, ','));
    let inside = delimited((multispace0, '('), values, (multispace0, cut_err(')'.context(CLOSED_OR_COMMA))));
    let given: Option<Vec<Tree>> = opt(inside).parse_next(input)?;
    let end = winnow::stream::Location::previous_token_end(input);
    Ok(match given {
        Some(arguments) => Tree { node: Node::Call { function, arguments }, place: place.start..end },
        None => Tree { node: Node::Name { text: name.to_owned(), index: usize::MAX }, place },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As it would be written with all brackets.
    fn shown(tree: &Tree) -> String {
        match &tree.node {
            Node::Number(value) => value.to_string(),
            Node::Name { text, .. } => text.clone(),
            Node::Call { function, arguments } => {
                let inside: Vec<String> = arguments.iter().map(shown).collect();
                format!("{function:?}({})", inside.join(","))
            }
        }
    }

    #[test]
    fn operators_bind_as_in_mathematics() {
        for (text, wanted) in [
            ("a+b*c", "Add(a,Multiply(b,c))"),
            ("a-b-c", "Subtract(Subtract(a,b),c)"),
            ("a/b/c", "Divide(Divide(a,b),c)"),
            ("-x^2", "Negate(Power(x,2))"),
            ("a^b^c", "Power(a,Power(b,c))"),
            ("2^-x*3", "Multiply(Power(2,Negate(x)),3)"),
            ("-a*b", "Multiply(Negate(a),b)"),
            (" ( a + 1e-3 ) * .5 ", "Multiply(Add(a,0.001),0.5)"),
            ("atan2(y, x) + clamp(x,-1,1)", "Add(Atan2(y,x),Clamp(x,Negate(1),1))"),
            ("- g/l*sin(q)-d*w", "Subtract(Multiply(Divide(Negate(g),l),Sin(q)),Multiply(d,w))"),
        ] {
            assert_eq!(shown(&parse(text).unwrap()), wanted, "{text}");
        }
    }

    #[test]
    fn every_mistake_has_its_place() {
        for (text, at, wanted) in [
            ("", 0, "expected a number, a name, a function or `(`, found the end"),
            ("a +", 3, "expected a number, a name, a function or `(`, found the end"),
            ("a + * b", 4, "expected a number, a name, a function or `(`, found `*`"),
            ("(a + b", 6, "expected an operator or `)`, found the end"),
            ("a + b)", 5, "expected an operator or the end of the formula, found `)`"),
            ("2 x_m", 2, "expected an operator or the end of the formula, found `x_m`; a product is written `a*b`"),
            ("min(a; b)", 5, "expected an operator, `,` or `)`, found `;`"),
            ("min(a)", 0, "expected 2 values for `min`, found 1 value"),
            ("sin(a, b)", 0, "expected 1 value for `sin`, found 2 values"),
            (
                "a * sine (x)",
                4,
                "expected one of the functions abs, sign, min, max, sqrt, cbrt, exp, ln, sin, cos, \
                 tan, atan2, tanh, clamp, delay, found `sine`",
            ),
            ("2(x)", 1, "expected an operator or the end of the formula, found `(`; a product is written `a*b`"),
            (
                "a = b",
                2,
                "expected an operator or the end of the formula, found `=`; what a formula gives is the name of its key",
            ),
            ("--a ----- b", 8, "expected at most 4 signs in a row, found 5"),
            ("1e999", 0, "expected a number, a name, a function or `(`, found `1e999`"),
        ] {
            let refused = parse(text).unwrap_err();
            assert_eq!((refused.to_string().as_str(), refused.place.start), (wanted, at), "{text}");
        }
    }

    #[test]
    fn what_other_languages_write_is_said_in_the_words_of_a_formula() {
        for (text, at, advice) in [
            ("a**2", 2, "a power is written `x^2`"),
            ("pow(a, 2)", 0, "a power is written `x^2`"),
            ("a * (b > 0)", 7, "there is no comparison"),
            ("if(a, b, c)", 0, "there is no comparison"),
            ("a == b", 2, "there is no comparison"),
            ("9,81 * a", 1, "a decimal number has a point"),
            ("a \u{2212} b", 2, "a minus is written `-`"),
            ("3 sin(a)", 2, "a product is written `a*b`"),
            ("Sin(a)", 0, "functions are written in small letters"),
            ("log(a)", 0, "`ln` is the natural logarithm"),
        ] {
            let refused = parse(text).unwrap_err();
            assert!(refused.found.contains(&format!("; {advice}")), "{text}: {}", refused.found);
            assert_eq!(refused.place.start, at, "{text}");
        }
        // What has no counterpart is left as it is.
        assert_eq!(parse("a % b").unwrap_err().found, "`%`");
        assert_eq!(parse("a + * b").unwrap_err().found, "`*`");
    }

    #[test]
    fn what_is_too_much_is_refused_at_once() {
        let deep = format!("{}a{}", "(".repeat(100_000), ")".repeat(100_000));
        assert!(parse(&deep).unwrap_err().to_string().contains("at most 4000 bytes"));
        let deep = format!("{}a{}", "(".repeat(33), ")".repeat(33));
        assert!(parse(&deep).unwrap_err().to_string().contains("at most 32 brackets within brackets"));
        let long = vec!["a"; 600].join("+");
        assert!(parse(&long).unwrap_err().to_string().contains("at most 500 operators"));
        assert!(parse(&vec!["a"; 500].join("^")).is_ok());
    }
}
