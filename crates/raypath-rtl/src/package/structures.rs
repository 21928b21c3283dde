//! Fields as types: one for each distinct structure.

use crate::package::fields::Field;
use crate::package::text::packed;
use raypath_hdl::text::Structure;

/// The greatest length of a name that consists of the names of the fields: `xyz_t`, `min_max_t`.
const SHORT: usize = 9;

/// The types of structures and of their parts; a type comes after the types of its fields.
#[derive(Debug)]
pub struct Structures {
    pub types: Vec<Structure>,
    /// The names that parts cannot have.
    taken: Vec<String>,
}

impl Structures {
    /// The types with these names and fields. An opcode is a vector: Yosys 0.23 finds no type of another package in a
    /// package.
    pub fn new(structures: &[(&str, &[Field])]) -> Self {
        let taken = structures.iter().map(|(name, _)| name.to_string()).collect();
        let mut found = Self { types: Vec::new(), taken };
        for (name, fields) in structures {
            let fields = found.fields(fields, name.trim_end_matches("_t"));
            found.types.push(Structure { name: name.to_string(), doc: None, fields });
        }
        found
    }

    /// The types and names of fields; `path` leads to them.
    fn fields(&mut self, fields: &[Field], path: &str) -> Vec<(String, String)> {
        let mut typed = Vec::new();
        for field in fields {
            let kind = match field {
                Field::Port { width, .. } => packed(*width),
                Field::Group { name, fields } => self.group(fields, &format!("{path}_{name}")),
            };
            typed.push((kind, field.name().to_string()));
        }
        typed
    }

    /// The type of a group, which may be one that exists already.
    fn group(&mut self, members: &[Field], path: &str) -> String {
        let fields = self.fields(members, path);
        if let Some(known) = self.types.iter().find(|known| known.fields == fields) {
            return known.name.clone();
        }
        let is_flat = members.iter().all(|member| matches!(member, Field::Port { .. }));
        let short = Some(joined(members)).filter(|name| is_flat && name.len() <= SHORT);
        let without_index = path.trim_end_matches(|c: char| c.is_ascii_digit() || c == '_');
        let stems = short.into_iter().chain([without_index.to_string(), path.to_string()]);
        let numbered = (2..).map(|number| format!("{path}_{number}"));
        let names = stems.chain(numbered).map(|stem| format!("{stem}_t"));
        let name = names.into_iter().find(|name| !self.is_taken(name)).unwrap_or_default();
        self.types.push(Structure { name: name.clone(), doc: None, fields });
        name
    }

    fn is_taken(&self, name: &str) -> bool {
        self.taken.iter().chain(self.types.iter().map(|known| &known.name)).any(|known| known == name)
    }
}

/// The joined names of the fields: letters without separators, words with underscores.
fn joined(members: &[Field]) -> String {
    let names: Vec<&str> = members.iter().map(Field::name).collect();
    names.join(if names.iter().all(|name| name.len() == 1) { "" } else { "_" })
}
