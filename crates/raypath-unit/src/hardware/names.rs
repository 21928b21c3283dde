//! The parameters of the unit by name, as options, files and keywords have them.

use super::parameters::UnitParameters;

const NODES: &str = "wide4 or quantised";

impl UnitParameters {
    /// The names of the parameters. `step.stack` is `stack`, `step.node` is `node`.
    pub const NAMES: [&str; 6] = ["contexts", "stack", "node", "memory-width", "id-width", "divider-latency"];

    /// Sets the parameter of this name. Returns `None` if there is none.
    ///
    /// ```
    /// use raypath_unit::UnitParameters;
    ///
    /// let mut parameters = UnitParameters::default();
    /// assert_eq!(parameters.set("memory-width", "128"), Some(Ok(())));
    /// assert_eq!(parameters.memory_width, 128);
    /// let problem = "'5', expected 2, 4, 8, 16 or 32".to_string();
    /// assert_eq!(parameters.set("stack", "5"), Some(Err(problem)));
    /// assert_eq!(parameters.set("node", "quantised"), Some(Ok(())));
    /// assert_eq!(parameters.get("node").as_deref(), Some("quantised"));
    /// let problem = "'5', expected wide4 or quantised".to_string();
    /// assert_eq!(parameters.set("node", "5"), Some(Err(problem)));
    /// assert_eq!(parameters.set("lanes", "4"), None);
    /// ```
    ///
    /// # Errors
    /// A value that the parameter does not have: what was found, and what was expected.
    pub fn set(&mut self, name: &str, value: &str) -> Option<Result<(), String>> {
        let mut changed = *self;
        if name == "node" {
            let Ok(node) = value.parse() else { return Some(Err(format!("'{value}', expected {NODES}"))) };
            changed.step.node = node;
            let checked = changed.check().map(|()| *self = changed);
            return Some(checked.map_err(|error| error.to_string()));
        }
        // No parameter has the greatest value, so that other text gets the same message.
        *changed.field(name)? = value.parse().unwrap_or(u32::MAX);
        let checked = changed.check().map(|()| *self = changed);
        Some(checked.map_err(|error| format!("'{value}', expected {}", error.expected)))
    }

    /// The value of the parameter of this name, if there is one.
    pub fn get(mut self, name: &str) -> Option<String> {
        if name == "node" {
            return Some(self.step.node.to_string());
        }
        self.field(name).map(|value| value.to_string())
    }

    fn field(&mut self, name: &str) -> Option<&mut u32> {
        match name {
            "contexts" => Some(&mut self.contexts),
            "stack" => Some(&mut self.step.stack),
            "memory-width" => Some(&mut self.memory_width),
            "id-width" => Some(&mut self.id_width),
            "divider-latency" => Some(&mut self.divider_latency),
            _ => None,
        }
    }
}
