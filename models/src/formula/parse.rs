//! From text to terms.

use std::ops::Range;

use super::{DEEPEST, FUNCTIONS, FormulaError, FormulaProblem, LONGEST, Node, Operator, Term};
use crate::nearest::nearest;

/// What a text is made of.
#[derive(Clone, Debug, PartialEq)]
enum Token {
    Number(f64),
    Name(String),
    Operator(Operator),
    Open,
    Close,
    Comma,
    End,
}

/// Reads a formula; names are checked by who knows them.
/// # Errors
/// [`FormulaError`] with the place of what cannot be read.
pub fn parse(text: &str) -> Result<Term, FormulaError> {
    if text.chars().count() > LONGEST {
        return Err(FormulaError { span: 0..text.len(), problem: FormulaProblem::TooLarge });
    }
    let mut reader = Reader { tokens: tokens(text)?, at: 0, depth: 0 };
    let term = reader.sum()?;
    match reader.peek() {
        Token::End => Ok(term),
        _ => Err(reader.unexpected("an operator or the end")),
    }
}

fn tokens(text: &str) -> Result<Vec<(Token, Range<usize>)>, FormulaError> {
    let mut tokens = Vec::new();
    let mut rest = text.char_indices().peekable();
    while let Some((start, c)) = rest.next() {
        let mut end = start + c.len_utf8();
        let operator = match c {
            _ if c.is_whitespace() => continue,
            '+' => Some(Operator::Add),
            '-' | '−' => Some(Operator::Subtract),
            '*' if text[end..].starts_with('*') => {
                rest.next();
                end += 1;
                Some(Operator::Power)
            }
            '*' | '·' => Some(Operator::Multiply),
            '/' => Some(Operator::Divide),
            '^' => Some(Operator::Power),
            _ => None,
        };
        let token = match c {
            _ if operator.is_some() => operator.map(Token::Operator),
            '(' => Some(Token::Open),
            ')' => Some(Token::Close),
            ',' => Some(Token::Comma),
            '0'..='9' | '.' => {
                end = start + number(&text[start..]);
                text[start..end].parse().ok().filter(|number: &f64| number.is_finite()).map(Token::Number)
            }
            _ if c == '_' || c.is_alphabetic() => {
                // Of digits only the plain ones: ² is a power, and no part of a name.
                let is_inside = |c: char| c == '_' || c.is_ascii_digit() || c.is_alphabetic();
                end = text[start..].find(|c| !is_inside(c)).map_or(text.len(), |length| start + length);
                Some(Token::Name(text[start..end].to_owned()))
            }
            _ => {
                let instead = match c {
                    '<' | '>' | '=' | '?' | '!' => "min, max and sign make a law of several pieces",
                    '[' | ']' | '{' | '}' => "write ( and )",
                    '²' => "write ^2",
                    '³' => "write ^3",
                    _ => "it has numbers, names, + - * / ^ ( ) and functions",
                };
                return Err(FormulaError {
                    span: start..end,
                    problem: FormulaProblem::Character { character: c, instead },
                });
            }
        };
        let Some(token) = token else {
            let problem = FormulaProblem::Unexpected { found: quoted(&text[start..end]), due: "a number" };
            return Err(FormulaError { span: start..end, problem });
        };
        tokens.push((token, start..end));
        while rest.peek().is_some_and(|(at, _)| *at < end) {
            rest.next();
        }
    }
    tokens.push((Token::End, text.len()..text.len()));
    Ok(tokens)
}

/// Bytes of the number that a text begins with.
fn number(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits = |from: usize| from + bytes[from..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    let mut end = digits(0);
    if bytes.get(end) == Some(&b'.') {
        end = digits(end + 1);
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let first = end + 1 + usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        if bytes.get(first).is_some_and(u8::is_ascii_digit) {
            end = digits(first);
        }
    }
    end
}

fn quoted(text: &str) -> String {
    format!("`{text}`")
}

struct Reader {
    tokens: Vec<(Token, Range<usize>)>,
    at: usize,
    depth: usize,
}

impl Reader {
    fn peek(&self) -> &Token {
        &self.tokens[self.at].0
    }

    fn span(&self) -> Range<usize> {
        self.tokens[self.at].1.clone()
    }

    /// The end is never passed.
    fn next(&mut self) {
        self.at = (self.at + 1).min(self.tokens.len() - 1);
    }

    fn unexpected(&self, due: &'static str) -> FormulaError {
        let found = match self.peek() {
            Token::Number(number) => quoted(&number.to_string()),
            Token::Name(name) => quoted(name),
            Token::Operator(operator) => quoted(symbol(*operator)),
            Token::Open => quoted("("),
            Token::Close => quoted(")"),
            Token::Comma => quoted(","),
            Token::End => "the end".to_owned(),
        };
        FormulaError { span: self.span(), problem: FormulaProblem::Unexpected { found, due } }
    }

    /// One level deeper.
    fn within<T>(
        &mut self,
        read: impl FnOnce(&mut Self) -> Result<T, FormulaError>,
    ) -> Result<T, FormulaError> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(FormulaError { span: self.span(), problem: FormulaProblem::TooLarge });
        }
        let found = read(self);
        self.depth -= 1;
        found
    }

    /// Parts with operators of one rank between them, from left to right.
    fn chain(
        &mut self,
        operators: [Operator; 2],
        part: impl Fn(&mut Self) -> Result<Term, FormulaError>,
    ) -> Result<Term, FormulaError> {
        let mut left = part(self)?;
        while let Token::Operator(operator) = *self.peek()
            && operators.contains(&operator)
        {
            self.next();
            let right = part(self)?;
            left = binary(operator, left, right);
        }
        Ok(left)
    }

    fn sum(&mut self) -> Result<Term, FormulaError> {
        self.chain([Operator::Add, Operator::Subtract], Self::product)
    }

    fn product(&mut self) -> Result<Term, FormulaError> {
        self.chain([Operator::Multiply, Operator::Divide], Self::unary)
    }

    fn unary(&mut self) -> Result<Term, FormulaError> {
        let start = self.span().start;
        match *self.peek() {
            Token::Operator(Operator::Subtract) => {
                self.next();
                let inner = self.within(Self::unary)?;
                let span = start..inner.span.end;
                Ok(Term { node: Node::Negative(Box::new(inner)), span })
            }
            Token::Operator(Operator::Add) => {
                self.next();
                self.within(Self::unary)
            }
            _ => self.power(),
        }
    }

    fn power(&mut self) -> Result<Term, FormulaError> {
        let base = self.atom()?;
        if *self.peek() != Token::Operator(Operator::Power) {
            return Ok(base);
        }
        self.next();
        let exponent = self.within(Self::unary)?;
        Ok(binary(Operator::Power, base, exponent))
    }

    fn atom(&mut self) -> Result<Term, FormulaError> {
        let span = self.span();
        let node = match self.peek().clone() {
            Token::Number(number) => Node::Number(number),
            Token::Name(name) => {
                self.next();
                return match self.peek() {
                    Token::Open => self.call(&name, span),
                    _ if name == "pi" => Ok(Term { node: Node::Number(std::f64::consts::PI), span }),
                    _ => Ok(Term { node: Node::Name(name), span }),
                };
            }
            Token::Open => {
                self.next();
                let inner = self.within(Self::sum)?;
                let end = self.close()?;
                return Ok(Term { span: span.start..end, ..inner });
            }
            _ => return Err(self.unexpected("a number, a name or a parenthesis")),
        };
        self.next();
        Ok(Term { node, span })
    }

    /// Where the parenthesis that closes here ends.
    fn close(&mut self) -> Result<usize, FormulaError> {
        if *self.peek() != Token::Close {
            return Err(self.unexpected("an operator or `)`"));
        }
        let end = self.span().end;
        self.next();
        Ok(end)
    }

    fn call(&mut self, name: &str, span: Range<usize>) -> Result<Term, FormulaError> {
        let function = FUNCTIONS.iter().find(|(known, _)| *known == name).map(|(_, function)| *function);
        let Some(function) = function else {
            let known = FUNCTIONS.iter().map(|(known, _)| (*known).to_owned()).collect();
            let near = nearest(name, FUNCTIONS.iter().map(|(known, _)| *known)).map(str::to_owned);
            let problem = FormulaProblem::Name { name: format!("{name}()"), nearest: near, known };
            return Err(FormulaError { span, problem });
        };
        self.next();
        let mut arguments = vec![self.within(Self::sum)?];
        while *self.peek() == Token::Comma {
            self.next();
            arguments.push(self.within(Self::sum)?);
        }
        let span = span.start..self.close()?;
        let [due, found] = [function.arguments(), arguments.len()];
        if due != found {
            let problem = FormulaProblem::Arguments { function: function.name(), due, found };
            return Err(FormulaError { span, problem });
        }
        Ok(Term { node: Node::Call(function, arguments), span })
    }
}

fn binary(operator: Operator, left: Term, right: Term) -> Term {
    let span = left.span.start..right.span.end;
    Term { node: Node::Binary(operator, Box::new([left, right])), span }
}

/// An operator as it is written.
pub fn symbol(operator: Operator) -> &'static str {
    match operator {
        Operator::Add => "+",
        Operator::Subtract => "-",
        Operator::Multiply => "*",
        Operator::Divide => "/",
        Operator::Power => "^",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fully(term: &Term) -> String {
        match &term.node {
            Node::Number(number) => number.to_string(),
            Node::Name(name) => name.clone(),
            Node::Negative(inner) => format!("(-{})", fully(inner)),
            Node::Binary(operator, sides) => {
                format!("({}{}{})", fully(&sides[0]), symbol(*operator), fully(&sides[1]))
            }
            Node::Call(function, arguments) => {
                format!("{}({})", function.name(), arguments.iter().map(fully).collect::<Vec<_>>().join(","))
            }
        }
    }

    #[test]
    fn binds_as_in_mathematics() {
        for (text, expected) in [
            ("a - b - c", "((a-b)-c)"),
            ("-a^2 * b", "((-(a^2))*b)"),
            ("a^-2^b", "(a^(-(2^b)))"),
            ("a**2/b·c", "(((a^2)/b)*c)"),
            ("1.5e-3a", ""),
            ("max(-a, 2. + .5)", "max((-a),(2+0.5))"),
            ("((a))", "a"),
        ] {
            match parse(text) {
                Ok(term) => assert_eq!(fully(&term), expected, "{text}"),
                Err(error) => assert_eq!(expected, "", "{text}: {error}"),
            }
        }
    }

    #[test]
    fn says_what_is_wrong_and_where() {
        for (text, at, message) in [
            ("", 0..0, "the end stands where a number, a name or a parenthesis is due"),
            ("c * * v", 4..5, "`*` stands where a number, a name or a parenthesis is due"),
            ("c * (v", 6..6, "the end stands where an operator or `)` is due"),
            ("c v", 2..3, "`v` stands where an operator or the end is due"),
            ("a < b", 2..3, "`<` is no part of a formula; min, max and sign make a law of several pieces"),
            ("sqr(a)", 0..3, "no `sqr()` here; did you mean `sqrt`?"),
            ("max(a)", 0..6, "max takes 2 arguments, not 1"),
            ("1e999", 0..5, "`1e999` stands where a number is due"),
            ("κ²", 2..4, "`²` is no part of a formula; write ^2"),
        ] {
            let error = parse(text).unwrap_err();
            assert_eq!(error.span, at, "{text}: {error}");
            assert!(error.to_string().starts_with(message), "{text}: {error}");
        }
    }

    #[test]
    fn no_depth_of_parentheses_overflows() {
        for text in [&"(".repeat(900), &"-".repeat(900), &"a^".repeat(450), &"+".repeat(2000)] {
            assert_eq!(parse(text).unwrap_err().problem, FormulaProblem::TooLarge);
        }
        assert!(parse(&format!("a{}", "+a".repeat(400))).is_ok());
    }
}
