//! The syntax of Liberty, the format of cell libraries: nested groups with attributes. `library.rs` interprets them.

use std::ops::Range;

/// `kind (names) { attributes and groups }`. An attribute in parentheses, `unit (1, pf);`, is a group without a body.
#[derive(Debug)]
pub struct Group<'a> {
    pub kind: &'a str,
    pub names: Vec<&'a str>,
    /// `name : value;`, strings without their quotes.
    pub attributes: Vec<(&'a str, &'a str)>,
    pub groups: Vec<Group<'a>>,
    /// The bytes of the text that it spans.
    pub span: Range<usize>,
}

/// A syntax error: the line from 1, what was found and what was expected.
#[derive(Debug, PartialEq, Eq)]
pub struct SyntaxError {
    pub line: usize,
    pub found: String,
    pub expected: &'static str,
}

/// The limit on the nesting of groups; libraries with current sources have seven levels.
const MAX_LEVELS: usize = 32;
/// The limit on the number of groups, attributes and names: enough for 256 MiB of a library's text, at about 100 bytes
/// each.
const MAX_PARTS: usize = 8 << 20;

/// Parses a file, which is one group.
pub fn read(text: &str) -> Result<Group<'_>, SyntaxError> {
    read_parts(text, MAX_PARTS)
}

fn read_parts(text: &str, max_parts: usize) -> Result<Group<'_>, SyntaxError> {
    let mut reader = Reader { text, at: 0, levels: 0, parts_left: max_parts };
    match reader.statement()? {
        Statement::Group(group) if group.kind == "library" => Ok(group),
        _ => Err(SyntaxError { line: 1, found: "something else".to_string(), expected: "library (name) { ... }" }),
    }
}

impl<'a> Group<'a> {
    /// The first name; empty if there is none.
    pub fn name(&self) -> &'a str {
        self.names.first().copied().unwrap_or_default()
    }

    /// The value of an attribute.
    pub fn attribute(&self, name: &str) -> Option<&'a str> {
        self.attributes.iter().find(|(known, _)| *known == name).map(|(_, value)| *value)
    }

    /// The inner groups of a kind.
    pub fn of_kind(&self, kind: &'static str) -> impl Iterator<Item = &Group<'a>> {
        self.groups.iter().filter(move |group| group.kind == kind)
    }
}

enum Statement<'a> {
    Attribute(&'a str, &'a str),
    Group(Group<'a>),
}

struct Reader<'a> {
    text: &'a str,
    at: usize,
    /// The number of open groups.
    levels: usize,
    /// The number of groups, attributes and names that may follow.
    parts_left: usize,
}

impl<'a> Reader<'a> {
    fn statement(&mut self) -> Result<Statement<'a>, SyntaxError> {
        self.skip_blank();
        self.part()?;
        let begin = self.at;
        let kind = self.word();
        if kind.is_empty() {
            return Err(self.error("the name of an attribute or a group"));
        }
        self.skip_blank();
        match self.peek() {
            Some(b':') => {
                self.at += 1;
                Ok(Statement::Attribute(kind, self.value()?))
            }
            Some(b'(') => {
                self.at += 1;
                let names = self.names()?;
                let mut group = Group { kind, names, attributes: vec![], groups: vec![], span: begin..begin };
                self.skip_blank();
                match self.peek() {
                    Some(b'{') => self.body(&mut group)?,
                    Some(b';') => self.at += 1,
                    _ => {}
                }
                group.span.end = self.at;
                Ok(Statement::Group(group))
            }
            _ => Err(self.error("':' or '('")),
        }
    }

    fn body(&mut self, group: &mut Group<'a>) -> Result<(), SyntaxError> {
        if self.levels == MAX_LEVELS {
            return Err(self.error("groups at most 32 deep"));
        }
        self.levels += 1;
        self.at += 1;
        loop {
            self.skip_blank();
            match self.peek() {
                Some(b'}') => {
                    self.at += 1;
                    self.levels -= 1;
                    return Ok(());
                }
                // Some writers end a group with a semicolon.
                Some(b';') => self.at += 1,
                None => return Err(self.error("'}'")),
                Some(_) => match self.statement()? {
                    Statement::Attribute(name, value) => group.attributes.push((name, value)),
                    Statement::Group(inner) => group.groups.push(inner),
                },
            }
        }
    }

    /// The names between parentheses; the opening one is already consumed.
    fn names(&mut self) -> Result<Vec<&'a str>, SyntaxError> {
        let mut names = Vec::new();
        loop {
            self.skip_blank();
            self.part()?;
            match self.peek() {
                Some(b')') => {
                    self.at += 1;
                    return Ok(names);
                }
                Some(b',') => self.at += 1,
                Some(b'"') => names.push(self.string()?),
                _ => match self.word() {
                    "" => return Err(self.error("')'")),
                    word => names.push(word),
                },
            }
        }
    }

    fn value(&mut self) -> Result<&'a str, SyntaxError> {
        self.skip_blank();
        if self.peek() == Some(b'"') {
            return self.string();
        }
        let rest = &self.text[self.at..];
        let value = &rest[..rest.find([';', '\n', '}']).unwrap_or(rest.len())];
        self.at += value.len();
        Ok(value.trim())
    }

    fn string(&mut self) -> Result<&'a str, SyntaxError> {
        let rest = &self.text[self.at + 1..];
        let Some(length) = rest.find('"') else { return Err(self.error("a string that ends")) };
        self.at += length + 2;
        Ok(&rest[..length])
    }

    fn word(&mut self) -> &'a str {
        let rest = &self.text[self.at..];
        let ends = |c: char| c.is_whitespace() || "(){}:;,\"".contains(c);
        let word = &rest[..rest.find(ends).unwrap_or(rest.len())];
        self.at += word.len();
        word
    }

    /// Skips white space, comments and line continuations.
    fn skip_blank(&mut self) {
        loop {
            let rest = &self.text[self.at..];
            let passed = if let Some(comment) = rest.strip_prefix("/*") {
                comment.find("*/").map_or(rest.len(), |end| end + 4)
            } else if rest.starts_with("//") {
                rest.find('\n').unwrap_or(rest.len())
            } else {
                rest.find(|c: char| !c.is_whitespace() && c != '\\').unwrap_or(rest.len())
            };
            if passed == 0 {
                return;
            }
            self.at += passed;
        }
    }

    /// Counts a group, attribute or name.
    fn part(&mut self) -> Result<(), SyntaxError> {
        let too_many = || self.error("at most 8388608 groups, attributes and names");
        self.parts_left = self.parts_left.checked_sub(1).ok_or_else(too_many)?;
        Ok(())
    }

    fn peek(&self) -> Option<u8> {
        self.text.as_bytes().get(self.at).copied()
    }

    fn error(&self, expected: &'static str) -> SyntaxError {
        let line = self.text[..self.at].matches('\n').count() + 1;
        let found = match self.text[self.at..].chars().next() {
            Some(character) => format!("'{}'", character.escape_debug()),
            None => "the end".to_string(),
        };
        SyntaxError { line, found, expected }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: &str = r#"/* a comment */
library(small) {
  capacitive_load_unit (1,pf);
  // another
  lu_table_template(t) { index_1 ("1.0, \
     2.0"); };
  cell ("AND2") {
    area : 6.5;
    dont_use : true ;
    pin(Y) { direction : output; function : "(A B)" }
  }
}
"#;

    #[test]
    fn groups_attributes_and_strings() {
        let library = read(SMALL).expect("Liberty");
        assert_eq!(library.name(), "small");
        let unit = library.of_kind("capacitive_load_unit").next().expect("a unit");
        assert_eq!(unit.names, ["1", "pf"]);
        let cell = library.of_kind("cell").next().expect("a cell");
        assert_eq!(cell.attributes, [("area", "6.5"), ("dont_use", "true")]);
        assert!(SMALL[cell.span.clone()].starts_with("cell (\"AND2\")"));
        assert!(SMALL[cell.span.clone()].trim_end().ends_with("}\n  }"));
        let pin = &cell.groups[0];
        assert_eq!((pin.name(), pin.attribute("function"), pin.attribute("absent")), ("Y", Some("(A B)"), None));
    }

    #[test]
    fn errors_name_the_line() {
        let fails = |text: &str| read(text).map(|group| group.kind.len()).expect_err("an error");
        assert_eq!(
            fails("library(x) {\n area : 1;\n"),
            SyntaxError { line: 3, found: "the end".to_string(), expected: "'}'" }
        );
        assert_eq!(
            fails("library(x) {\n\n  {"),
            SyntaxError { line: 3, found: "'{'".to_string(), expected: "the name of an attribute or a group" }
        );
        assert_eq!(fails("module x;").line, 1);
        assert_eq!(fails("library(x) { a : \"b }").expected, "a string that ends");
        assert_eq!(fails("cell(x) { }").expected, "library (name) { ... }");
    }

    /// Each level is a call: a million levels would overflow the stack.
    #[test]
    fn depth_is_bounded() {
        let nested = |levels: usize| format!("library(x) {{\n{}{}}}", "g(){".repeat(levels), "}".repeat(levels));
        assert!(read(&nested(MAX_LEVELS - 1)).is_ok());
        for levels in [MAX_LEVELS, 1_000_000] {
            let error = read(&nested(levels)).map(|group| group.span).expect_err("too deep");
            assert_eq!((error.line, error.expected), (2, "groups at most 32 deep"));
        }
    }

    /// Three bytes of text can take a hundred bytes of memory.
    #[test]
    fn parts_are_bounded() {
        for part in ["a:;", "a()", "b,"] {
            let begin = if part == "b," { "library(" } else { "library(x){" };
            let text = format!("{begin}{}", part.repeat(1000));
            let error = read_parts(&text, 1000).map(|group| group.span).expect_err("too many");
            assert_eq!(error.expected, "at most 8388608 groups, attributes and names", "{part}");
        }
    }
}
