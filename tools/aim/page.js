// The page of umax aim: its buttons copy.
"use strict";
for (const button of document.querySelectorAll("[data-copy]"))
  button.onclick = async () => {
    const from = document.getElementById(button.dataset.copy), said = button.nextElementSibling;
    try {
      await navigator.clipboard.writeText(from.textContent);
      said.textContent = "Copied.";
    } catch {
      getSelection().selectAllChildren(from);
      said.textContent = document.execCommand("copy") ? "Copied." : "Selected: copy it with Ctrl+C.";
    }
  };
