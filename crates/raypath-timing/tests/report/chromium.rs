//! A tab of Chromium, driven over its DevTools protocol. With `--remote-debugging-pipe`, Chromium reads JSON messages
//! from file descriptor 3 and writes them to 4, each terminated by a zero byte.

use serde_json::{Value, json};
use std::cell::RefCell;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

const CHROMIUM: &str = "/usr/bin/chromium";
const FLAGS: [&str; 11] = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--force-device-scale-factor=1",
    "--window-size=1400,1500",
    "--remote-debugging-pipe",
];

/// A page in its own browser.
pub struct Page {
    tab: RefCell<Tab>,
    _folder: tempfile::TempDir,
}

impl Page {
    /// Opens the text of a page as a file.
    pub fn open(text: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("page.html");
        std::fs::write(&file, text).expect("a page");
        let tab = Tab::open(&format!("file://{}", file.display()), &folder.path().join("profile"));
        Self { tab: RefCell::new(tab), _folder: folder }
    }

    /// The value of a JavaScript expression as text.
    pub fn value(&self, expression: &str) -> String {
        let expression = format!("(async () => String(await ({expression})))()");
        let parameters = json!({ "expression": expression, "awaitPromise": true, "returnByValue": true });
        let value = self.call("Runtime.evaluate", parameters);
        value["result"]["value"].as_str().unwrap_or_else(|| panic!("{expression} gave {value}")).to_string()
    }

    /// Calls a method of the protocol and waits for its result.
    pub fn call(&self, method: &str, parameters: Value) -> Value {
        self.tab.borrow_mut().call(method, parameters)
    }

    /// Messages of the console and uncaught exceptions, as JSON.
    pub fn messages(&self) -> Vec<String> {
        // The reply comes after all earlier events.
        self.value("0");
        let tab = self.tab.borrow();
        let kinds = ["Log.entryAdded", "Runtime.consoleAPICalled", "Runtime.exceptionThrown"];
        kinds.iter().flat_map(|kind| tab.events_of(kind)).map(ToString::to_string).collect()
    }

    pub fn assert_console_empty(&self) {
        assert_eq!(self.messages(), Vec::<String>::new());
    }
}

/// A tab in its own browser, which exits when the tab is dropped.
struct Tab {
    browser: Child,
    requests: Option<ChildStdin>,
    replies: BufReader<ChildStdout>,
    session: Option<String>,
    last_request: u64,
    events: Vec<Value>,
}

impl Tab {
    /// A tab with the page at `url`, loaded.
    fn open(url: &str, profile: &Path) -> Self {
        assert!(Path::new(CHROMIUM).exists(), "{CHROMIUM} is missing. help: install the Debian package chromium");
        let mut browser = Command::new("sh")
            .args(["-c", "exec timeout 300 \"$@\" 3<&0 4>&1 </dev/null >/dev/null 2>&1", "sh", CHROMIUM])
            .args(FLAGS)
            .arg(format!("--user-data-dir={}", profile.display()))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("sh runs");
        let requests = browser.stdin.take();
        let replies = BufReader::new(browser.stdout.take().expect("a pipe"));
        let mut tab = Self { browser, requests, replies, session: None, last_request: 0, events: Vec::new() };
        let target = tab.call("Target.createTarget", json!({ "url": "about:blank" }))["targetId"].take();
        let session = tab.call("Target.attachToTarget", json!({ "targetId": target, "flatten": true }));
        tab.session = session["sessionId"].as_str().map(str::to_string);
        for domain in ["Runtime", "Log", "Page"] {
            tab.call(&format!("{domain}.enable"), json!({}));
        }
        tab.call("Page.navigate", json!({ "url": url }));
        while tab.events_of("Page.loadEventFired").is_empty() {
            let event = tab.receive();
            tab.events.push(event);
        }
        tab
    }

    /// Calls a method of the protocol and waits for its result.
    fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.last_request += 1;
        let mut request = json!({ "id": self.last_request, "method": method, "params": parameters });
        if let Some(session) = &self.session {
            request["sessionId"] = session.as_str().into();
        }
        write!(self.requests.as_ref().expect("an open pipe"), "{request}\0").expect("Chromium reads");
        loop {
            let mut message = self.receive();
            if message["id"] == self.last_request {
                assert_eq!(message["error"], Value::Null, "{method}");
                return message["result"].take();
            }
            self.events.push(message);
        }
    }

    /// The parameters of all events of a method so far.
    fn events_of(&self, method: &str) -> Vec<&Value> {
        self.events.iter().filter(|event| event["method"] == method).map(|event| &event["params"]).collect()
    }

    fn receive(&mut self) -> Value {
        let mut message = Vec::new();
        self.replies.read_until(0, &mut message).expect("Chromium writes");
        assert_eq!(message.pop(), Some(0), "Chromium ended");
        serde_json::from_slice(&message).expect("a message in JSON")
    }
}

impl Drop for Tab {
    fn drop(&mut self) {
        // Chromium exits at the end of its requests.
        self.requests = None;
        self.browser.wait().expect("Chromium exits");
    }
}
