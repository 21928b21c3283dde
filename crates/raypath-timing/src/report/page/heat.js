"use strict";
// Switches the heat map between all operations and one.
(() => {
  const cells = document.querySelectorAll("#heat td[data-total]");
  const buttons = document.querySelectorAll("button[data-heat]");
  for (const button of buttons) {
    button.addEventListener("click", () => {
      const operation = Number(button.dataset.heat);
      for (const other of buttons) other.setAttribute("aria-pressed", String(other === button));
      for (const cell of cells) {
        const use = operation < 0 ? Number(cell.dataset.total) : Number(cell.dataset.by.split(" ")[operation] || 0);
        cell.style.setProperty("--use", Math.min(1, Math.max(0, use)).toFixed(4));
        cell.querySelector("b").textContent = (100 * use).toFixed(1) + "%";
      }
    });
  }
})();
