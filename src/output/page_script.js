const byId = id => document.getElementById(id);
// As JSON, long data are read several times faster than as a part of the script.
const data = JSON.parse(byId("data").textContent);
/// A node with this tag, these properties and children (nodes or text).
function element(tag, properties = {}, ...children) {
  const node = Object.assign(document.createElement(tag), properties);
  node.append(...children);
  return node;
}
const counted = (n, word) => `${n.toLocaleString("en")} ${word}${n === 1 ? "" : "s"}`;
const isNumber = x => typeof x === "number" && Number.isFinite(x);
/// Three digits, without an exponent where a reader can do without: "0.0123", "89,300", "1.2e9".
function brief(x) {
  if (!isNumber(x)) return x === null || x === undefined ? "–" : x === "inf" ? "∞" : String(x);
  const size = Math.abs(x);
  if (size !== 0 && (size < 1e-3 || size >= 1e7)) return x.toExponential(1).replace(".0e", "e").replace("e+", "e");
  return Number(x.toPrecision(3)).toLocaleString("en", {maximumFractionDigits: 6});
}

/// Copies text; also where the page may not use the clipboard by itself.
async function copyText(text) {
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    const area = element("textarea", {value: text});
    document.body.append(area);
    area.select();
    document.execCommand("copy");
    area.remove();
  }
}
/// A command and a button that copies it.
function commandLine(text) {
  const copy = element("button", {type: "button", className: "copy", textContent: "copy"});
  copy.onclick = async () => {
    await copyText(text);
    copy.textContent = "copied";
    setTimeout(() => { copy.textContent = "copy"; }, 1500);
  };
  return element("div", {className: "command"}, element("code", {textContent: text}), copy);
}

/// The look of a method from tools/charting/looks.json, as style.py has it: variants share a colour.
function lookOf(name, looks) {
  const plain = name.replace(/[@:].*/, "");
  for (const base of [plain, plain.replace(/-(double|single)$/, "")])
    if (base in looks.methods)
      return {color: looks.methods[base][0], hollow: base !== plain};
  const sum = [...plain].reduce((n, c) => n + c.codePointAt(0), 0);
  return {color: looks.foreign[sum % looks.foreign.length][0], hollow: false};
}
function swatch(name, looks) {
  const look = lookOf(name, looks), node = element("span", {className: look.hollow ? "swatch hollow" : "swatch"});
  node.style.setProperty("--method", look.color);
  node.setAttribute("aria-hidden", "true");
  return node;
}

/// A table that sorts by its headings. Columns have a title, value(row) to sort by, and optionally
/// cell(row) (what is shown), left, first (the larger value comes first), help and className(row).
/// Fields that a row lacks are shown as "–".
function makeTable(columns, rows, sorted = -1) {
  const body = element("tbody"), heads = element("tr");
  const table = element("table", {className: "data"}, element("thead", {}, heads), body);
  const choice = element("select", {ariaLabel: "Sort by"}, element("option", {textContent: "as listed", value: "-1"}));
  let order = sorted, descending = sorted >= 0 && Boolean(columns[sorted].first);
  const compare = (a, b) => {
    const x = columns[order].value(a), y = columns[order].value(b);
    const none = v => v === undefined || v === null || Number.isNaN(v);
    if (none(x) || none(y)) return none(x) - none(y);
    return (typeof x === "number" ? x - y : String(x) < String(y) ? -1 : String(x) > String(y) ? 1 : 0) * (descending ? -1 : 1);
  };
  function fill(shown = rows) {
    rows = shown;
    const list = order < 0 ? rows : [...rows].sort(compare);
    body.replaceChildren(...list.map(row => element("tr", {className: row.className ?? ""}, ...columns.map((c, i) => {
      const shownValue = c.cell ? c.cell(row) : c.value(row);
      const cell = element("td", {className: [c.left ? "left" : "", i === 0 ? "head" : "", c.className ? c.className(row) : ""].join(" ").trim()},
        shownValue instanceof Node ? shownValue : isNumber(shownValue) ? brief(shownValue) : shownValue ?? "–");
      cell.dataset.label = c.title;
      return cell;
    }))));
    [...heads.children].forEach((head, i) => {
      if (i === order) head.setAttribute("aria-sort", descending ? "descending" : "ascending");
      else head.removeAttribute("aria-sort");
    });
    choice.value = String(order);
  }
  const sortBy = i => {
    descending = i === order ? !descending : i >= 0 && Boolean(columns[i].first);
    order = i;
    fill();
  };
  columns.forEach((column, i) => {
    heads.append(element("th", {className: column.left ? "left" : "", scope: "col", title: column.help ?? ""},
      element("button", {type: "button", textContent: column.title, onclick: () => sortBy(i)})));
    choice.append(element("option", {textContent: column.title, value: String(i)}));
  });
  choice.onchange = () => { order = -2; sortBy(Number(choice.value)); };
  fill();
  return {table, fill, choice: element("label", {className: "sort-by"}, "Sort by ", choice)};
}

// What is folded on the screen is printed.
addEventListener("beforeprint", () => {
  for (const node of document.querySelectorAll("details:not([open]):not([data-unprinted])")) {
    node.open = true;
    node.dataset.opened = "";
  }
});
addEventListener("afterprint", () => {
  for (const node of document.querySelectorAll("details[data-opened]")) {
    node.open = false;
    delete node.dataset.opened;
  }
});
