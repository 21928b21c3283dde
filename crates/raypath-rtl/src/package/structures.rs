//! Fields as types: one for each distinct structure.

use crate::package::fields::Field;
use crate::package::text::packed;

/// A job.
pub const JOB_TYPE: &str = "job_t";

/// A result.
pub const OUTCOME_TYPE: &str = "outcome_t";

/// The greatest length of a name that consists of the names of the fields: `xyz_t`, `min_max_t`.
const SHORT: usize = 9;

/// The types of job and result; a type comes after the types of its fields.
#[derive(Debug)]
pub struct Structures {
    types: Vec<Structure>,
}

/// A packed structure.
#[derive(Debug)]
pub struct Structure {
    /// Its name.
    pub name: String,
    /// Its fields, the most significant first: type and name.
    pub fields: Vec<(String, String)>,
}

impl Structures {
    pub fn new(job: &[Field], outcome: &[Field]) -> Self {
        let mut structures = Self { types: Vec::new() };
        // The opcode is a vector: Yosys 0.23 finds no type of another package in a package.
        let fields = structures.fields(job, "job");
        structures.types.push(Structure { name: JOB_TYPE.to_string(), fields });
        let fields = structures.fields(outcome, "outcome");
        structures.types.push(Structure { name: OUTCOME_TYPE.to_string(), fields });
        structures
    }

    pub fn iter(&self) -> impl Iterator<Item = &Structure> {
        self.types.iter()
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
        self.types.push(Structure { name: name.clone(), fields });
        name
    }

    fn is_taken(&self, name: &str) -> bool {
        name == JOB_TYPE || name == OUTCOME_TYPE || self.types.iter().any(|known| known.name == name)
    }
}

/// The joined names of the fields: letters without separators, words with underscores.
fn joined(members: &[Field]) -> String {
    let names: Vec<&str> = members.iter().map(Field::name).collect();
    names.join(if names.iter().all(|name| name.len() == 1) { "" } else { "_" })
}
