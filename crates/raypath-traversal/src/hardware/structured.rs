//! Packed structures and arrays in the texts of the unit's modules.
//!
//! The netlist has a port or a signal for each field. Types follow from the ports of modules. Where names have all the
//! fields of a type after one prefix, the text has a variable in their place; numbered names become one word. All
//! fields in order are printed as their variable, so that the order of bits stays as it is.

use super::package::package;
use super::parametric::declaration;
use crate::step::UnitFeatures;
use raypath_hdl::text::{Package, Structure};
use raypath_hdl::verilog::Connections;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, HashMap};

const PACKAGE: &str = "raypath_unit_pkg::";

/// The types, each after those that it contains: the name, the module and the prefix of the ports that are its fields,
/// the beginnings of the names of those that are not, and what it is.
const TYPES: [(&str, &str, &str, &str, &str); 13] = [
    ("vector_t", "set_up", "entry_dir_", "", "A point or a direction."),
    ("state_t", "prepare", "state_", "any_hit root cull_mask t_min flags_", "What is kept of a ray between its steps."),
    ("group_t", "finish", "top_", "", "An entry of the stack: children of a node that wait."),
    ("closest_t", "distance", "closest_", "", "The closest hit of a block."),
    ("boxes_t", "walk", "boxes_", "valid", "The outcome of a box job."),
    ("answer_t", "prepare", "answer_", "", "What a ray learns in a step."),
    ("half_t", "prepare", "half_", "", "A step before the stack is read."),
    ("request_t", "finish", "request_", "", "What a ray asks for after a step, and what it pushes."),
    ("entry_t", "set_up", "entry_", "", "A ray as it enters."),
    ("constants_t", "rays", "job_", "read origin inside", "The constants of a ray."),
    ("limits_t", "rays", "limits_", "read", "What the hits of a ray depend on."),
    ("begin_t", "rays", "begin_", "", "What a ray begins with."),
    ("ended_t", "hits", "next_", "", "What a hit shows of the state of its ray."),
];

/// A type, or a variable in the place of names. Of each member: the name, or what follows the prefix in it; what is
/// printed, or what selects it; and its type. The most significant is first.
struct Group {
    kind: String,
    name: String,
    members: Vec<[String; 3]>,
}

/// A line of a text, with those that it continues on.
enum Line {
    /// The direction of a port, a type, a name, and the rest.
    Declared([String; 4]),
    /// What is before the connections; ports and nets.
    Instance(String, Vec<[String; 2]>),
    Other(String),
    Removed,
}

/// Texts of modules with structures, by their names, and the package that has these. Modules follow those that they
/// instantiate; the ports of the last stay as they are.
pub fn structured(texts: &[(String, String)], features: UnitFeatures) -> (BTreeMap<String, String>, Package) {
    let mut modules: Vec<(&str, Vec<Line>)> = texts.iter().map(|(name, text)| (name.as_str(), lines(text))).collect();
    let (mut types, mut structures): (Vec<Group>, Vec<Structure>) = Default::default();
    for (name, module, prefix, without, doc) in TYPES {
        let of_module = modules.iter().filter(|(known, _)| known.strip_prefix("raypath_unit_") == Some(module));
        let fields: Vec<[String; 2]> =
            of_module.flat_map(|(_, lines)| lines).filter_map(|line| field(line, prefix, without)).collect();
        if fields.len() > 1 {
            let (members, fields) = members(&fields, &types);
            structures.push(Structure { name: name.to_string(), doc: Some(doc.to_string()), fields });
            types.push(Group { kind: format!("{PACKAGE}{name}"), name: String::new(), members });
            types.sort_by_key(|kind| Reverse(kind.members.len()));
        }
    }
    let top = modules.len().saturating_sub(1);
    let mut ports: HashMap<String, Vec<Group>> = HashMap::new();
    let mut written = BTreeMap::new();
    for (place, (name, lines)) in modules.iter_mut().enumerate() {
        let declared = lines.iter().filter_map(|line| match line {
            Line::Declared([direction, kind, name, _]) if place != top || direction.is_empty() => {
                Some([kind.clone(), name.clone()])
            }
            _ => None,
        });
        let mut declared: Vec<[String; 2]> = declared.collect();
        let mut variables = detected(&mut declared, &types);
        variables.extend(words(&declared, &texts[place].1));
        replace(lines, &variables, &ports);
        without_aliases(lines);
        ports.insert(name.to_string(), variables);
        written.insert(name.to_string(), text(lines));
    }
    (written, package(features, structures))
}

/// The type and the name of a field, if the line declares a port that is one, of a width without parameters.
fn field(line: &Line, prefix: &str, without: &str) -> Option<[String; 2]> {
    let Line::Declared([direction, kind, name, _]) = line else { return None };
    let field = name.strip_prefix(prefix)?.strip_suffix(if direction == "input  " { "_i" } else { "_o" })?;
    let is_other = without.split_whitespace().any(|other| field.starts_with(other));
    (!direction.is_empty() && !is_other && !kind.contains(char::is_uppercase))
        .then(|| [kind.clone(), field.to_string()])
}

/// The members of a type with these fields, and its fields with structures.
fn members(fields: &[[String; 2]], types: &[Group]) -> (Vec<[String; 3]>, Vec<(String, String)>) {
    let inner = detected(&mut fields.to_vec(), types);
    let (mut members, mut printed) = (Vec::new(), Vec::new());
    for [width, field] in fields {
        match find(&inner, field) {
            None => {
                // Fields are no keywords.
                let keywords = [("primitive", "primitive_index"), ("inside", "is_inside")].into_iter();
                let name = keywords.fold(field.clone(), |name, (from, to)| if name == from { to.into() } else { name });
                members.push([field.clone(), format!(".{name}"), width.clone()]);
                printed.push((width.clone(), name));
            }
            Some(group) if group.members[0][0] == *field => {
                let inside = group.members.iter().cloned();
                members.extend(inside.map(|[name, select, width]| [name, format!(".{select}"), width]));
                printed.push((group.kind.replace(PACKAGE, ""), group.name.clone()));
            }
            Some(_) => {}
        }
    }
    (members, printed)
}

/// The group that has this name as a member.
fn find<'g>(groups: &'g [Group], name: &str) -> Option<&'g Group> {
    groups.iter().find(|group| group.members.iter().any(|[member, ..]| member == name))
}

const SUFFIXES: [&str; 4] = ["_i", "_o", "_q", ""];

/// The variables of these types in the place of names, which are removed. The types with the most members are first.
fn detected(names: &mut Vec<[String; 2]>, types: &[Group]) -> Vec<Group> {
    let mut found = Vec::new();
    for kind in types {
        for ([_, name], suffix) in names.clone().iter().flat_map(|name| SUFFIXES.map(|suffix| (name, suffix))) {
            let first = format!("_{}{suffix}", kind.members[0][0]);
            let Some(prefix) = name.strip_suffix(&first).filter(|prefix| !prefix.is_empty()) else { continue };
            let name = format!("{prefix}{suffix}");
            let member = |[flat, select, width]: &[String; 3]| {
                [format!("{prefix}_{flat}{suffix}"), format!("{name}{select}"), width.clone()]
            };
            let members: Vec<[String; 3]> = kind.members.iter().map(member).collect();
            let is_there =
                |[flat, _, width]: &[String; 3]| names.iter().any(|[kind, name]| name == flat && kind == width);
            if members.iter().all(is_there) && names.iter().all(|[_, other]| *other != name) {
                names.retain(|[_, name]| members.iter().all(|[flat, ..]| flat != name));
                found.push(Group { kind: kind.kind.clone(), name, members });
            }
        }
    }
    found
}

/// Words in the place of three or more numbered names of one width, from 0 or from the first of a beat of a block, if the
/// text has none of their bits alone.
fn words(names: &[[String; 2]], text: &str) -> Vec<Group> {
    let mut numbered: BTreeMap<[&str; 3], BTreeSet<u32>> = BTreeMap::new();
    for [kind, name] in names {
        let suffix = SUFFIXES.into_iter().find(|suffix| name.ends_with(suffix)).unwrap_or("");
        let stem = name.strip_suffix(suffix).and_then(|name| name.rsplit_once('_'));
        if let Some((stem, number)) = stem.and_then(|(stem, number)| Some((stem, number.parse().ok()?))) {
            numbered.entry([stem, suffix, kind]).or_default().insert(number);
        }
    }
    let word = |([stem, suffix, kind], numbers): ([&str; 3], BTreeSet<u32>)| {
        let width = kind.strip_prefix("logic [")?.strip_suffix(":0]")?.parse::<u32>().ok()? + 1;
        let (first, count) = (*numbers.first()?, numbers.len() as u32);
        let name = format!("{stem}{suffix}");
        let is_run = count > 2 && first % 4 == 0 && numbers.last() == Some(&(first + count - 1));
        let member = |place: u32| {
            let select = format!("{name}[{}:{}]", width * (place + 1) - 1, width * place);
            [format!("{stem}_{}{suffix}", first + place), select, kind.to_string()]
        };
        let members: Vec<[String; 3]> = (0..count).rev().map(member).collect();
        let is_run = is_run && members.iter().all(|[name, ..]| !text.contains(&format!("{name}[")));
        (is_run && names.iter().all(|[_, other]| *other != name)).then(|| Group {
            kind: format!("logic [{}:0]", width * count - 1),
            members,
            name,
        })
    };
    numbered.into_iter().filter_map(word).collect()
}

/// Puts variables in the place of their names.
fn replace(lines: &mut [Line], variables: &[Group], ports: &HashMap<String, Vec<Group>>) {
    let members = || variables.iter().flat_map(|variable| &variable.members);
    let names: HashMap<String, String> = members().map(|[name, select, _]| (name.clone(), select.clone())).collect();
    // What is a whole of these: each variable, and each structure in it.
    let mut wholes: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for [_, select, _] in members() {
        let whole = |(end, _)| wholes.entry(&select[..end]).or_default().push(select.clone());
        select.match_indices(['.', '[']).for_each(whole);
    }
    let mut wholes: Vec<(&str, Vec<String>)> = wholes.into_iter().collect();
    wholes.sort_by_key(|(_, members)| Reverse(members.len()));
    let mut seen = BTreeSet::new();
    for line in lines.iter_mut() {
        match line {
            Line::Declared([_, kind, name, _]) => match find(variables, name) {
                Some(variable) if seen.insert(&variable.name) => {
                    (*kind, *name) = (variable.kind.clone(), variable.name.clone());
                }
                Some(_) => *line = Line::Removed,
                None => {}
            },
            Line::Instance(head, nets) => {
                let inside = head.split_whitespace().next().and_then(|module| ports.get(module));
                let mut connected: Vec<[String; 2]> = Vec::new();
                for [port, net] in nets.iter() {
                    let (port, parts) = match inside.and_then(|inside| find(inside, port)) {
                        Some(group) => {
                            let net = |[member, ..]: &[String; 3]| nets.iter().find(|[port, _]| port == member);
                            let nets = group.members.iter().filter_map(net);
                            (&group.name, nets.map(|[_, net]| net.clone()).collect())
                        }
                        None => {
                            let parts = net.strip_prefix('{').and_then(|net| net.strip_suffix('}')).map(items);
                            (port, parts.filter(|parts| parts.len() > 1).unwrap_or_else(|| vec![net.clone()]))
                        }
                    };
                    if connected.iter().all(|[known, _]| known != port) {
                        let parts = parts.iter().map(|part| renamed(part, &names)).collect();
                        connected.push([port.clone(), joined(parts, &wholes)]);
                    }
                }
                *nets = connected;
            }
            Line::Other(code) => *code = renamed(code, &names),
            Line::Removed => {}
        }
    }
    // One assignment in the place of those of all members.
    for (whole, members) in &wholes {
        let is_select = |value: &str| value.chars().all(|c| c.is_ascii_alphanumeric() || "_.[]:".contains(c));
        let of = |line, member: &str| assignment(line).filter(|[_, to, _, value]| *to == member && is_select(value));
        let place = |member: &String| lines.iter().position(|line| of(line, member).is_some());
        let Some(places) = members.iter().map(place).collect::<Option<Vec<usize>>>() else { continue };
        let found: Vec<[&str; 4]> = places.iter().filter_map(|place| assignment(&lines[*place])).collect();
        let value = joined(found.iter().map(|[.., value]| value.to_string()).collect(), &wholes);
        if 2 * value.matches(", ").count() < members.len() {
            let code = format!("{}{whole}{}{value};", found[0][0], found[0][2]);
            let first = places.iter().min().copied().unwrap_or(0);
            places.iter().for_each(|place| lines[*place] = Line::Removed);
            lines[first] = Line::Other(code);
        }
    }
}

/// Parts of a concatenation as one net, with wholes in the place of all of their members.
fn joined(mut parts: Vec<String>, wholes: &[(&str, Vec<String>)]) -> String {
    for (whole, members) in wholes {
        while let Some(at) = parts.windows(members.len()).position(|part| part == members) {
            parts.splice(at..at + members.len(), [whole.to_string()]);
        }
    }
    // Ranges of a word that follow each other.
    for at in (1..parts.len()).rev() {
        let merged = parts[at].split_once('[').and_then(|(name, range)| {
            let (left, right) = range.split_once(':')?;
            let before = parts[at - 1].strip_suffix(&format!(":{}]", left.parse::<u32>().ok()? + 1))?;
            let is_same =
                before.starts_with(&format!("{name}[")) && name.chars().all(|c| c.is_alphanumeric() || c == '_');
            is_same.then(|| format!("{before}:{right}"))
        });
        merged.into_iter().for_each(|merged| _ = parts.splice(at - 1..=at, [merged]));
    }
    if parts.len() == 1 { parts.remove(0) } else { format!("{{{}}}", parts.join(", ")) }
}

/// An assignment: what is before its target, the target, the operator and the value.
fn assignment(line: &Line) -> Option<[&str; 4]> {
    let Line::Other(code) = line else { return None };
    let rest = code.trim_start().trim_start_matches("assign ");
    let operator = if code.contains("assign ") { " = " } else { " <= " };
    let (target, value) = rest.strip_suffix(';')?.split_once(operator)?;
    let target = target.trim_end();
    (!target.contains(' ')).then(|| [&code[..code.len() - rest.len()], target, operator, value])
}

/// Removes signals that are another under a second name.
fn without_aliases(lines: &mut Vec<Line>) {
    for place in 0..lines.len() {
        let Some(["  assign ", target, _, source]) = assignment(&lines[place]) else { continue };
        let at =
            |name: &str| lines.iter().position(|line| matches!(line, Line::Declared([_, _, own, _]) if own == name));
        let (Some(own), Some(other)) = (at(target), at(source)) else { continue };
        let (Line::Declared(own), Line::Declared([direction, kind, ..])) = (&lines[own], &lines[other]) else {
            continue;
        };
        let has_comment = matches!(&lines[other - 1], Line::Other(code) if code.contains("//"));
        if own[1] != *kind || !direction.is_empty() || source.ends_with("_q") || has_comment || at(target) > Some(other)
        {
            continue;
        }
        let names = HashMap::from([(source.to_string(), target.to_string())]);
        (lines[other], lines[place]) = (Line::Removed, Line::Removed);
        for line in lines.iter_mut() {
            match line {
                Line::Instance(_, nets) => nets.iter_mut().for_each(|[_, net]| *net = renamed(net, &names)),
                Line::Other(code) => *code = renamed(code, &names),
                _ => {}
            }
        }
    }
    lines.retain(|line| !matches!(line, Line::Removed));
}

/// The code with other names, besides comments. What follows a point is a field.
fn renamed(code: &str, names: &HashMap<String, String>) -> String {
    let is_of_name = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '\'';
    let (mut out, mut rest) = (String::new(), code);
    while let Some(first) = rest.chars().next().filter(|_| !rest.starts_with("//")) {
        let end =
            if is_of_name(first) { rest.find(|c| !is_of_name(c)).unwrap_or(rest.len()) } else { first.len_utf8() };
        let (word, after) = rest.split_at(end);
        out += names.get(word).filter(|_| !out.ends_with('.')).map_or(word, String::as_str);
        rest = after;
    }
    out + rest
}

/// What commas separate outside of brackets.
fn items(text: &str) -> Vec<String> {
    let mut depth = 0;
    let is_between = |c: char| {
        depth += i32::from("([{".contains(c)) - i32::from(")]}".contains(c));
        c == ',' && depth == 0
    };
    text.split(is_between).map(|item| item.trim().to_string()).collect()
}

/// The lines of a text, with assignments and instances in one.
fn lines(text: &str) -> Vec<Line> {
    let mut whole: Vec<String> = Vec::new();
    let mut is_open = false;
    for line in text.lines() {
        match whole.last_mut() {
            Some(last) if is_open => *last = format!("{last} {}", line.trim()),
            _ => whole.push(line.to_string()),
        }
        let code = line.trim();
        let begins = ["assign ", "raypath"].iter().any(|word| code.starts_with(word)) || code.contains(" <= ");
        is_open =
            (is_open || begins) && ![";", "begin"].iter().any(|end| code.ends_with(end)) && !code.starts_with("//");
    }
    whole.into_iter().map(line).collect()
}

fn line(code: String) -> Line {
    if let Some((2, kind, rest)) = declaration(&code) {
        let (name, rest) = rest.split_at(rest.find([',', ';', ' ']).unwrap_or(rest.len()));
        let is_port = kind.starts_with("input") || kind.starts_with("output");
        let (direction, kind) = kind.split_at(if is_port { "output ".len() } else { 0 });
        return Line::Declared([direction, kind, name, rest.trim_start_matches([',', ';'])].map(str::to_string));
    }
    let instance = |code: &str| {
        let (head, nets) = code.strip_prefix("  raypath")?.strip_suffix(");")?.split_once(" u_")?;
        let (name, nets) = nets.split_once(" (")?;
        let net = |item: String| match item[1..].split_once(" (") {
            Some((port, net)) => [port, &net[..net.len() - 1]].map(str::to_string),
            None => [&item[1..]; 2].map(str::to_string),
        };
        Some(Line::Instance(format!("  raypath{head} u_{name}"), items(nets).into_iter().map(net).collect()))
    };
    instance(&code).unwrap_or(Line::Other(code))
}

/// The text of these lines, with aligned assignments.
fn text(lines: &[Line]) -> String {
    let is_port = |line: &Line| matches!(line, Line::Declared([direction, ..]) if !direction.is_empty());
    let last = lines.iter().rposition(is_port);
    let (mut out, mut longest) = (String::new(), 0);
    for (place, line) in lines.iter().enumerate() {
        out += &match line {
            Line::Declared([direction, kind, name, rest]) => {
                let end = if direction.is_empty() { ";" } else { "," };
                format!("  {direction}{kind} {name}{}{rest}", if last == Some(place) { "" } else { end })
            }
            Line::Instance(head, nets) => {
                let mut connections = Connections::default();
                nets.iter().for_each(|[port, net]| connections.add(port, net));
                let head = head.trim_start();
                let is_long = head.len() > 96;
                let head = if is_long { head.replacen(" u_", "\n      u_", 1) } else { head.to_string() };
                connections.print(&head).join("\n")
            }
            Line::Other(code) => match assignment(line) {
                None => code.clone(),
                Some([before, target, operator, value]) => {
                    let same = |line: &&Line| assignment(line).is_some_and(|[known, ..]| known == before);
                    if place == 0 || !same(&&lines[place - 1]) {
                        let run = lines[place..].iter().take_while(same).filter_map(assignment);
                        longest = run.map(|[_, target, ..]| target.len()).max().unwrap_or(0);
                    }
                    format!("{before}{target:<longest$}{operator}{value};")
                }
            },
            Line::Removed => continue,
        };
        out.push('\n');
    }
    let (body, end) = out.rsplit_once("\n\nendmodule").unwrap_or((&out, ""));
    // Outputs may have no assignments left.
    let body = body.trim_end_matches('-').trim_end_matches("\n\n  // ---- Outputs ").replace("\n\n\n", "\n\n");
    format!("{body}\n\nendmodule{end}")
}
