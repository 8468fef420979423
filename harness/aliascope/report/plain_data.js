// What a page shows, as plain JSON.

const documentData = JSON.parse(document.getElementById("data").textContent);
