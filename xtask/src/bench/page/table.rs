//! Tables of whatever rows a report has.

use maud::{Markup, html};
use serde_json::Value;

/// A table of `rows`, a column for each member; members of members become columns too, and lists of numbers one.
pub(crate) fn show(rows: &[Value]) -> Markup {
    let flat: Vec<Vec<(String, Value)>> = rows.iter().map(flat).collect();
    let mut titles: Vec<String> = Vec::new();
    for (title, _) in flat.iter().flatten() {
        if !titles.contains(title) {
            titles.push(title.clone());
        }
    }
    let number = |title: &str| {
        let mut cells = flat.iter().flatten().filter(|(t, v)| t == title && !v.is_null());
        cells.all(|(_, value)| value.is_number() || value.is_array()).then_some("n")
    };
    html! {
        div.scroll { table {
            tr { @for title in &titles { th class=[number(title)] { (title.replace('_', " ")) } } }
            @for row in &flat {
                tr { @for title in &titles {
                    td class=[number(title)] { @if let Some((_, value)) = row.iter().find(|(t, _)| t == title) { (cell(value)) } }
                } }
            }
        } }
    }
}

fn flat(row: &Value) -> Vec<(String, Value)> {
    let Some(members) = row.as_object() else { return vec![("value".to_owned(), row.clone())] };
    members
        .iter()
        .flat_map(|(name, value)| match value {
            // Rows within a row are counted: they have tables of their own, or are too many.
            Value::Array(inner) if inner.iter().any(Value::is_object) => {
                vec![(name.clone(), inner.len().into())]
            }
            Value::Object(_) => {
                flat(value).into_iter().map(|(inner, v)| (format!("{name} {inner}"), v)).collect()
            }
            _ => vec![(name.clone(), value.clone())],
        })
        .collect()
}

fn cell(value: &Value) -> String {
    match value {
        Value::Null => "–".to_owned(),
        Value::Bool(is) => if *is { "yes" } else { "no" }.to_owned(),
        Value::String(text) => text.clone(),
        Value::Array(all) => all.iter().map(cell).collect::<Vec<_>>().join(" / "),
        Value::Number(number) => match number.as_f64() {
            Some(n) if !number.is_i64() && !number.is_u64() => short(n),
            _ => number.to_string(),
        },
        Value::Object(_) => value.to_string(),
    }
}

/// Four digits.
pub(crate) fn short(n: f64) -> String {
    match n.abs() {
        0.0 => "0".to_owned(),
        a if !(1e-3..1e6).contains(&a) => format!("{n:.2e}"),
        a => format!("{n:.*}", (3 - a.log10().floor() as i32).clamp(0, 5) as usize),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits() {
        assert_eq!(
            [0.0, 1.23456, 123.456, 4567.8, 1.5e-7, 2.5e9].map(short),
            ["0", "1.235", "123.5", "4568", "1.50e-7", "2.50e9"]
        );
    }

    #[test]
    fn members_become_columns() {
        let rows = [serde_json::json!({ "name": "a <b>", "ns": [1.0, 2.0], "of": { "x": 3 } })];
        let text = show(&rows).into_string();
        for part in ["<th>name</th>", "a &lt;b&gt;", "1.000 / 2.000", "of x"] {
            assert!(text.contains(part), "{part} in {text}");
        }
    }
}
