// Runs before the page is drawn: the chosen theme, and words that come up over the page.
"use strict";

window.cellctl = (() => {
  const THEME = "cellctl-theme";
  const NOTICE_S = 8;
  const root = document.documentElement;
  const light = () => {
    const wanted = root.dataset.theme;
    return wanted === "auto" || !wanted
      ? window.matchMedia("(prefers-color-scheme: light)").matches
      : wanted === "light";
  };

  const chosen = () => {
    try {
      return localStorage.getItem(THEME);
    } catch {
      return null; // a browser that keeps nothing follows the cell's own theme
    }
  };
  root.lang = document.currentScript.dataset.language;
  root.dataset.theme = chosen() ?? document.currentScript.dataset.theme;

  const theme = () => {
    const next = light() ? "dark" : "light";
    try {
      localStorage.setItem(THEME, next);
    } catch {
      // it holds until the page is loaded again
    }
    root.dataset.theme = next;
  };

  let shelf;
  const notice = (text) => {
    if (!shelf) {
      shelf = document.createElement("div");
      shelf.className = "notices";
      shelf.setAttribute("role", "alert");
      document.body.append(shelf);
    }
    const line = document.createElement("p");
    line.className = "notices__line";
    line.textContent = text;
    shelf.replaceChildren(line);
    setTimeout(() => line.remove(), NOTICE_S * 1000);
  };

  // Saves the picture that a link leads to as a PNG, which every phone can show; else as it is.
  const save = async (link) => {
    const image = new Image();
    image.src = link.href;
    try {
      await image.decode();
    } catch {
      window.open(link.href);
      return;
    }
    const canvas = document.createElement("canvas");
    canvas.width = image.naturalWidth;
    canvas.height = image.naturalHeight;
    canvas.getContext("2d").drawImage(image, 0, 0);
    canvas.toBlob((blob) => {
      const saved = document.createElement("a");
      saved.href = URL.createObjectURL(blob);
      saved.download = link.getAttribute("download").replace(/svg$/, "png");
      saved.click();
      setTimeout(() => URL.revokeObjectURL(saved.href), 10000);
    }, "image/png");
  };

  // The arrow keys go from tab to tab of the operator's view.
  const tabKeys = (event) => {
    const tabs = [...event.currentTarget.querySelectorAll("[role=tab]")];
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    const now = tabs.indexOf(document.activeElement);
    if (!step || now < 0) return;
    event.preventDefault();
    const next = tabs[(now + step + tabs.length) % tabs.length];
    next.focus();
    next.click();
  };

  const leadTo = (id) => {
    const target = document.getElementById(id);
    if (!target) return;
    target.scrollIntoView({ block: "start" });
    target.querySelector("input:not([disabled]), button:not([disabled])")?.focus();
  };

  // What is typed and not yet taken outlives the page that it was typed into, but not its visitor:
  // the next one before the same screen does not find it.
  const TYPED = "cellctl-typed";
  const TYPED_FOR_MS = 120_000;
  const typed = (field) => {
    try {
      sessionStorage.setItem(TYPED, JSON.stringify({ text: field.value, at: Date.now() }));
    } catch {
      // it lives as long as the page
    }
  };
  const typedBefore = (id) => {
    const field = document.getElementById(id);
    try {
      const { text, at } = JSON.parse(sessionStorage.getItem(TYPED) ?? "{}");
      if (field && !field.value && Date.now() - at < TYPED_FOR_MS) field.value = text;
    } catch {
      // nothing was kept
    }
  };
  const taken = (id, text) => {
    const field = document.getElementById(id);
    if (!field || field.value.trim() !== text) return;
    field.value = "";
    typed(field);
  };

  // The page library tells in English that its server is gone.
  const { lost, back } = document.currentScript.dataset;
  document.addEventListener("DOMContentLoaded", () => {
    const said = document.querySelectorAll("#popup span");
    [lost, back].forEach((text, at) => said[at] && (said[at].textContent = text));
    document.getElementById("popup")?.setAttribute("role", "alert");
  });

  return { save, theme, notice, light, tabKeys, leadTo, typed, typedBefore, taken };
})();
