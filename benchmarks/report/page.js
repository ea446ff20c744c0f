// Sort the overview by a column, and leave out what the filter does not name.
for (const table of document.querySelectorAll("table.overview")) {
  const heads = [...table.tHead.rows[0].cells];
  const body = table.tBodies[0];
  const value = (row, column) => row.cells[column].dataset.value ?? "";
  heads.forEach((head, column) => {
    head.querySelector("button").addEventListener("click", () => {
      const isText = head.dataset.kind === "text";
      const before = head.getAttribute("aria-sort");
      // The first click shows the best: names from A, errors and times from the least, the others from the most.
      const first = isText || head.dataset.lowest === "yes" ? "ascending" : "descending";
      const other = first === "ascending" ? "descending" : "ascending";
      const order = before === first ? other : first;
      heads.forEach((each) => each.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", order);
      const sign = order === "ascending" ? 1 : -1;
      const rows = [...body.rows].sort((a, b) => {
        const one = value(a, column), two = value(b, column);
        if (one === "" || two === "") return (one === "") - (two === "");  // what is missing stands last
        return sign * (isText ? one.localeCompare(two, undefined, {numeric: true}) : one - two);
      });
      body.append(...rows);
    });
  });
  const filter = document.querySelector("#filter");
  filter.hidden = body.rows.length < 10;
  filter.addEventListener("input", () => {
    const words = filter.value.toLowerCase().split(/\s+/).filter(Boolean);
    for (const row of body.rows) {
      const text = [...row.cells].filter((_, i) => heads[i].dataset.kind === "text").map((c) => c.textContent).join(" ").toLowerCase();
      row.hidden = !words.every((word) => text.includes(word));
    }
  });
}
