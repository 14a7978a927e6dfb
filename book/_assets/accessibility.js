// Mends what a screen reader, and voice control, would trip over in the theme (sphinx-book-theme 1.2).
(() => {
  "use strict";

  const mend = () => {
    // A visible text must be part of the name; where there is such a text, it is the name.
    for (const element of document.querySelectorAll(".search-button-field[aria-label], summary[aria-label]:not(:has(.toctree-toggle))")) {
      element.removeAttribute("aria-label");
    }
    // The arrow that folds out the sections of a chapter is only a picture.
    for (const arrow of document.querySelectorAll("summary:has(.toctree-toggle):not([aria-label])")) {
      arrow.setAttribute("aria-label", `Sections of ${arrow.closest("li").querySelector("a").textContent.trim()}`);
    }
    // The button has a name of its own; the names of the three pictures in it are not seen.
    for (const picture of document.querySelectorAll(".theme-switch-button svg:not([aria-hidden=true])")) {
      picture.setAttribute("aria-hidden", "true");
    }
    for (const title of document.querySelectorAll(".theme-switch-button svg title")) title.remove();
    // A list has list items. (This role for the entries of a bibliography is deprecated.)
    for (const entry of document.querySelectorAll("[role=list] > [role=doc-biblioentry]")) {
      entry.setAttribute("role", "listitem");
    }
    // The book's title stands outside of all landmarks.
    const title = document.querySelector(".sidebar-primary-item:has(> .navbar-brand):not([role])");
    title?.setAttribute("role", "navigation");
    title?.setAttribute("aria-label", "Book title");
  };

  document.addEventListener("DOMContentLoaded", () => {
    mend();
    // Font Awesome puts its pictures in place later.
    new MutationObserver(mend).observe(document.body, { childList: true, subtree: true });
  });
})();
