//! Writing JSON (RFC 8259): objects built key by key, for the filters that report to scripts.

use std::fmt::Write as _;

/// A value as JSON text.
#[derive(Clone, Debug, PartialEq)]
pub struct Json(String);

impl Json {
    /// What is not there, or is no number.
    pub fn null() -> Json {
        Json("null".into())
    }

    /// A list.
    pub fn list<T: Into<Json>>(items: impl IntoIterator<Item = T>) -> Json {
        let items: Vec<String> = items.into_iter().map(|i| i.into().0).collect();
        Json(format!("[{}]", items.join(",")))
    }

    /// An object, its keys in this order.
    ///
    /// ```
    /// use luxpipe::json::Json;
    /// let o = Json::object([("a", Json::from(0.5)), ("b", "x\"\n".into()), ("c", f64::NAN.into())]);
    /// assert_eq!(o.to_string(), r#"{"a":0.5,"b":"x\"\n","c":null}"#);
    /// ```
    pub fn object<'a>(items: impl IntoIterator<Item = (&'a str, Json)>) -> Json {
        let items: Vec<String> = items.into_iter().map(|(k, v)| format!("{}:{}", Json::from(k), v)).collect();
        Json(format!("{{{}}}", items.join(",")))
    }
}

impl std::fmt::Display for Json {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl From<&str> for Json {
    fn from(text: &str) -> Json {
        let mut out = String::from("\"");
        for c in text.chars() {
            let _ = match c {
                '"' | '\\' => write!(out, "\\{c}"),
                '\n' => write!(out, "\\n"),
                '\t' => write!(out, "\\t"),
                c if crate::error::is_deceptive(c) => write!(out, "\\u{:04x}", c as u32),
                c => write!(out, "{c}"),
            };
        }
        Json(out + "\"")
    }
}

/// Text from outside; what is not UTF-8 becomes U+FFFD.
impl From<&[u8]> for Json {
    fn from(text: &[u8]) -> Json {
        Json::from(&*String::from_utf8_lossy(text))
    }
}

/// The shortest digits that give the same number again; JSON has no NaN and no infinity, they are null.
impl From<f64> for Json {
    fn from(x: f64) -> Json {
        if x.is_finite() { Json(format!("{x:?}")) } else { Json::null() }
    }
}

impl From<f32> for Json {
    fn from(x: f32) -> Json {
        if x.is_finite() { Json(format!("{x:?}")) } else { Json::null() }
    }
}

impl From<i32> for Json {
    fn from(n: i32) -> Json {
        Json(n.to_string())
    }
}

impl From<u64> for Json {
    fn from(n: u64) -> Json {
        Json(n.to_string())
    }
}

impl From<usize> for Json {
    fn from(n: usize) -> Json {
        Json(n.to_string())
    }
}

impl<T: Into<Json>> From<Option<T>> for Json {
    fn from(value: Option<T>) -> Json {
        value.map_or(Json::null(), Into::into)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_escaped_and_numbers_are_json_numbers() {
        assert_eq!(Json::from("a\\\u{1b}\u{7f}\u{85}é\t").to_string(), r#""a\\\u001b\u007f\u0085é\t""#);
        assert_eq!(Json::from(&b"\xff\0"[..]).to_string(), "\"\u{fffd}\\u0000\"");
        let numbers = [0.0, -1.5, 1e300, 1e-7, f64::INFINITY];
        assert_eq!(Json::list(numbers).to_string(), "[0.0,-1.5,1e300,1e-7,null]");
        assert_eq!(Json::list([Some(1u64), None]).to_string(), "[1,null]");
    }
}
