//! The reference page of scene files, docs/scene-reference.md: every table and field, made from the types that read them, by their JSON schema.

use super::file::SceneFile;
use serde_json::{Map, Value};
use std::fmt::Write;

/// The page, as Markdown.
pub(super) fn page() -> String {
    let schema = schemars::schema_for!(SceneFile).to_value();
    let mut page = String::from(
        "# Fields of scene files\n\n\
         Made from the types that read scenes: `caustic scene schema --page > docs/scene-reference.md`. [scene-format.md](scene-format.md) is the guide.\n",
    );
    let nothing = Map::new();
    let definitions = schema["$defs"].as_object().unwrap_or(&nothing);
    section(&mut page, "Top level", &schema);
    // Tables in the order in which the top level names them, and then what these name.
    let mut names = Vec::new();
    named(&schema["properties"], &mut names);
    let mut at = 0;
    while at < names.len() {
        let definition = &definitions[&names[at]];
        named(definition, &mut names);
        let about = text(definition);
        match about.split_once(": ") {
            Some((heading, about)) if heading.starts_with('`') => {
                section(&mut page, heading, &described(definition, &capitalised(about)));
            }
            _ => section(&mut page, &format!("`{}`", names[at].trim_end_matches("Table").to_lowercase()), definition),
        }
        at += 1;
    }
    page
}

/// The same with another description.
fn described(definition: &Value, about: &str) -> Value {
    let mut definition = definition.clone();
    definition["description"] = Value::from(about);
    definition
}

fn capitalised(text: &str) -> String {
    let mut rest = text.chars();
    rest.next().map_or(String::new(), |first| first.to_uppercase().chain(rest).collect())
}

/// Names of definitions that `value` refers to and `names` lacks.
fn named(value: &Value, names: &mut Vec<String>) {
    match value {
        Value::Object(fields) => {
            if let Some(name) = reference(value)
                && !names.iter().any(|known| known == name)
            {
                names.push(name.to_string());
            }
            fields.values().for_each(|value| named(value, names));
        }
        Value::Array(values) => values.iter().for_each(|value| named(value, names)),
        _ => {}
    }
}

fn reference(value: &Value) -> Option<&str> {
    value["$ref"].as_str()?.strip_prefix("#/$defs/")
}

fn text(value: &Value) -> &str {
    value["description"].as_str().unwrap_or_default()
}

/// One paragraph, as a cell of a table wants it.
fn cell(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ").replace('|', "\\|")
}

fn section(page: &mut String, heading: &str, definition: &Value) {
    let _ = write!(page, "\n## {heading}\n\n{}\n", text(definition));
    if let Some(fields) = definition["properties"].as_object() {
        let nothing = Vec::new();
        let required = definition["required"].as_array().unwrap_or(&nothing);
        let _ = write!(page, "\n| field | | what it is | meaning |\n| --- | --- | --- | --- |\n");
        for must in [true, false] {
            for (name, field) in fields.iter().filter(|(name, _)| must == required.iter().any(|r| r == *name)) {
                let need = if must { "must be given" } else { "" };
                let _ = writeln!(page, "| `{name}` | {need} | {} | {} |", kind(field), cell(text(field)));
            }
        }
    }
    if let Some(choices) = definition["oneOf"].as_array() {
        let _ = write!(page, "\n| value | meaning |\n| --- | --- |\n");
        for choice in choices {
            let _ = writeln!(page, "| `{}` | {} |", choice["const"], cell(text(choice)));
        }
    }
}

/// What a field's value is, in words.
fn kind(field: &Value) -> String {
    if let Some(name) = reference(field) {
        return match name.strip_suffix("Table") {
            Some(table) => format!("`{}` table", table.to_lowercase()),
            None => format!("`{}`", name.to_lowercase()),
        };
    }
    if let Some(choices) = field["anyOf"].as_array() {
        let choices = choices.iter().filter(|choice| choice["type"] != "null");
        return choices.map(kind).collect::<Vec<_>>().join(" or ");
    }
    let types: Vec<&str> = match &field["type"] {
        Value::String(one) => vec![one],
        Value::Array(some) => some.iter().filter_map(Value::as_str).filter(|one| *one != "null").collect(),
        _ => Vec::new(),
    };
    match types.first() {
        Some(&"array") => match field["minItems"].as_u64() {
            Some(count) => format!("{count} × {}", kind(&field["items"])),
            None => format!("list of {}", kind(&field["items"])),
        },
        Some(&"object") => format!("tables by name: {}", kind(&field["additionalProperties"])),
        Some(&"integer") => "whole number".to_string(),
        Some(&"string") => "text".to_string(),
        Some(&"boolean") => "true or false".to_string(),
        Some(other) => (*other).to_string(),
        None => "anything".to_string(),
    }
}
